"""Systems of blocks that depend on one another, as one force law of the engine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, cast

from jousto.base.errors import InputError, Problem, suggest
from jousto.mechanism.forces.base import ForceElement, Packed, Push
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.signals.base import Signal
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression, leaves_of
from jousto.model.native.header import kinds, packed
from jousto.model.packing.program import BLOCK, LEAVES, Program


class System(ForceElement):
    """Blocks that depend on one another, and expressions that are measured.

    Parameters
    ----------
    number : int
        Number of the system.
    blocks : sequence of Block
        Blocks of the system.
    watched : sequence of Expression
        Expressions that sensors measure.
    """

    kind = "states"
    number: int
    blocks: tuple[Block, ...]
    watched: tuple[Expression, ...]
    _made: _Assembly

    def __init__(self, number: int, blocks: Sequence[Block], watched: Sequence[Expression]) -> None:
        values = {
            "name": ", ".join(block.name for block in blocks) or "expressions",
            "number": number,
            "blocks": tuple(blocks),
            "watched": tuple(watched),
            "_made": _Assembly(blocks, watched),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The system as a law of the engine."""
        names = tuple(f"{block.name}.{name}" for block, name in self._made.states)
        openings = tuple(name for name, _ in self._made.openings)
        network = Push(
            "network", {}, numbers=self._packed, states=names, active=True, openings=openings
        )
        # delays before memories: their inputs at the end of a step are those before it
        return (network, *map(self._delay, self._made.delays), *map(self._kept, self._made.kept))

    def _delay(self, delay: _Delay) -> Push:
        """Return a delay as a law of the engine."""
        block: Any = delay.block
        data = packed(
            "jo_delay_data",
            network=self.number,
            input=self._made.register[delay.input],
            slope=-1 if delay.slope is None else self._made.register[delay.slope],
            time=block.time,
            points=block.points,
            given=block.initial is not None,
            initial=0.0 if block.initial is None else block.initial,
            size=block.size,
        )
        ring = (f"{what}{i + 1}" for i in range(block.points) for what in ("time", "value", "rate"))
        states = tuple(f"{block.name}.{name}" for name in ("points", "jumps", "first", *ring))
        return Push("delay", {}, numbers=lambda _: Packed(data), states=states)

    def _kept(self, memory: _Memory) -> Push:
        """Return what a block keeps within steps as a law of the engine."""
        block, made = memory.block, self._made
        names = ("samples", *memory.names)
        data = packed(
            "jo_memory_data",
            [block.memories[name] for name in memory.names],
            [made.register[node] for node in memory.updates],
            network=self.number,
            first=memory.first,
            count=len(memory.names),
            period=block.period,
            phase=block.phase + memory.delay,
            margin=-1 if memory.margin is None else made.register[memory.margin],
            jumps=block.jumps,
            jitter=block.jitter,
            seed=block.seed,
        )
        states = tuple(f"{block.name}.{name}" for name in names)
        return Push("memory", {}, numbers=lambda _: Packed(data), states=states)

    @property
    def registers(self) -> dict[int, int]:
        """Registers of the watched expressions by their id."""
        made = self._made
        pairs = zip(self.watched, made.seen, strict=True)
        return {id(one): made.register[node] for one, node in pairs}

    def _signal(self, builder: Any, one: Signal | Block) -> int:
        """Return the index of a signal of time, or of the output of a delay."""
        if isinstance(one, Signal):
            return int(builder.signal(one))
        delays = [delay.block for delay in self._made.delays]
        return int(builder.delayed(1 + len(builder.forces) + delays.index(one)))

    def _packed(self, builder: Any) -> Packed:
        made = self._made
        places = [builder.declared(c) for c in made.coordinates]
        ends = [(builder.coordinates[k].a, builder.coordinates[k].b) for k in places]
        bodies = {builder.markers[i].body for pair in ends for i in pair} - {-1}
        sizes = [(block.starts[name], block.nominals.get(name, 1.0)) for block, name in made.states]
        data = packed(
            "jo_network_data",
            [start for start, _ in sizes],
            [size for _, size in sizes],
            places,
            [self._signal(builder, one) for one in made.signals],
            made.constants,
            made.code,
            [made.register[node] for node in made.rates],
            [x for k, node in made.pushes for x in (k, made.register[node])],
            [x for row, column, node in made.slopes for x in (row, column, made.register[node])],
            [made.register[node] for _, node in made.openings],
            number=self.number,
            states=len(made.states),
            coordinates=len(places),
            signals=len(made.signals),
            constants=len(made.constants),
            values=made.values,
            instructions=len(made.code) // 4,
            pushes=len(made.pushes),
            slopes=len(made.slopes),
            memories=made.memories,
            gravity=made.gravity,
            openings=len(made.openings),
        )
        return Packed(data, coupled=(tuple(sorted(bodies)),))


class _Memory(NamedTuple):
    """Memories of a block that change together, and their delay after a sample, s.

    Then the first one in the system; entries of next values and margin.
    """

    block: Block
    names: Sequence[str]
    delay: float
    first: int
    updates: list[int]
    margin: int | None


class _Delay(NamedTuple):
    """Block that delays; entries of its input and the rate of this, None if it is not known."""

    block: Block
    input: int
    slope: int | None


class _Assembly:
    """Program of a system, and what its registers mean."""

    def __init__(self, blocks: Sequence[Block], watched: Sequence[Expression]) -> None:
        self.program = Program()
        self.coordinates: list[Coordinate] = []
        self.signals: list[Signal | Block] = []
        self.states = [(block, name) for block in blocks for name in block.starts]
        self._state = {(id(block), name): i for i, (block, name) in enumerate(self.states)}
        kept = [(block, name) for block in blocks for name in block.memories]
        self._memory = {(id(block), name): i for i, (block, name) in enumerate(kept)}
        self.memories = len(kept)
        self._no_rate = False
        self._named = {block.name: block for block in blocks}
        self._equations: dict[int, Equations] = {}
        self._blocks = blocks
        self._outputs: dict[tuple[int, str], int] = {}
        self._nodes: dict[int, int] = {}
        self._places: dict[Any, int] = {}
        equations = [self._of(block) for block in blocks]
        self._add_outputs()
        self.rates = [
            self._node(one.rates[name])
            for block, one in zip(blocks, equations, strict=True)
            for name in block.starts
        ]
        self.pushes = [
            (self._coordinate(c), self._node(force)) for one in equations for c, force in one.forces
        ]
        self.kept = [
            self._remember(block, one, names, delay)
            for block, one in zip(blocks, equations, strict=True)
            for names, delay in block.changes
        ]
        self.delays = [
            self._delayed(block, one.delayed)
            for block, one in zip(blocks, equations, strict=True)
            if one.delayed is not None
        ]
        self.seen = [self._node(one) for one in watched]
        self.openings = [
            (f"{name} of {block.kind} {block.name!r}", self._node(one))
            for block in blocks
            for name, one in block.openings.items()
        ]
        self._differentiate()
        self._lay_out()

    def _of(self, block: Block) -> Equations:
        if id(block) not in self._equations:
            self._equations[id(block)] = block.checked()
        return self._equations[id(block)]

    def _remember(
        self, block: Block, equations: Equations, names: Sequence[str], delay: float
    ) -> _Memory:
        first = self._memory[id(block), names[0]]
        self._no_rate = False
        updates = [self._node(equations.updates[name]) for name in names]
        margin = None if equations.margin is None else self._node(equations.margin)
        return _Memory(block, names, delay, first, updates, None if self._no_rate else margin)

    def _delayed(self, block: Block, of: Expression) -> _Delay:
        node = self._node(of)
        self._no_rate = False
        slope = self._rate_of(node)
        return _Delay(block, node, None if self._no_rate else slope)

    def _rate_of(self, node: int) -> int:
        """Return the total derivative of an entry by time; 0 if it needs accelerations."""
        p = self.program
        total = p.number(0.0)
        leaves = ("state", "value", "rate", "time", "signal")
        for (kind, i), slope in p.derivatives(node, leaves).items():
            if kind == "rate":
                self._no_rate = True
                return p.number(0.0)
            if kind == "state":
                own = self.rates[i]
            else:
                of_time = {"value": "rate", "signal": "signal rate"}.get(kind)
                own = p.number(1.0) if of_time is None else p.leaf(of_time, i)
            total = p.add("add", total, p.add("multiply", slope, own))
        return total

    def _coordinate(self, coordinate: Coordinate) -> int:
        key = coordinate.key
        if key not in self._places:
            self._places[key] = len(self.coordinates)
            self.coordinates.append(coordinate)
        return self._places[key]

    def _node(self, one: Expression) -> int:
        """Return the entry of an expression; outputs are replaced by what they consist of."""
        stack = [one]
        while stack:  # no recursion: expressions may be deep
            at = stack[-1]
            if id(at) in self._nodes:
                stack.pop()
                continue
            missing = [part for part in at.operands if id(part) not in self._nodes]
            if missing:
                stack += missing
                continue
            self._nodes[id(at)] = self._entry(at)
            stack.pop()
        return self._nodes[id(one)]

    def _entry(self, one: Expression) -> int:
        p, kind = self.program, one.operation
        if kind == "rate of":
            return self._rate_of(self._nodes[id(one.operands[0])])
        if one.operands:
            return p.add(kind, *(self._nodes[id(part)] for part in one.operands))
        if kind == "number":
            return p.number(one.of)
        if kind == BLOCK:
            return p.numbers(one.of)
        if kind == "time":
            return p.leaf("time")
        if kind == "gravity":
            return p.leaf("gravity", one.of)
        if kind in ("value", "rate"):
            return p.leaf(kind, self._coordinate(one.of))
        if kind in ("signal", "delayed"):  # a delayed value is a function of time within a step
            if not any(one.of is other for other in self.signals):
                self.signals.append(one.of)
            return p.leaf("signal", next(i for i, x in enumerate(self.signals) if x is one.of))
        block, name = self._target(one)
        if name in block.starts:
            return p.leaf("state", self._state[id(block), name])
        if name in block.memories:
            return p.leaf("memory", self._memory[id(block), name])
        return self._outputs[id(block), name]

    def _target(self, leaf: Expression) -> tuple[Block, str]:
        """Return the block and the name of the state or output to which a leaf refers."""
        of, name = leaf.of
        return (self._named[of] if leaf.operation == "named" else of), name

    def _add_outputs(self) -> None:
        """Add all outputs, each after those that it needs.

        Raises
        ------
        InputError
            If outputs need one another.
        """
        on_path: list[tuple[Block, str]] = []
        stack = [(block, name) for block in self._blocks for name in block.outputs]
        while stack:  # depth first, without recursion: chains of blocks may be long
            block, name = stack[-1]
            key = (id(block), name)
            if key in self._outputs:
                stack.pop()
                continue
            if on_path and on_path[-1] == (block, name):  # all that it needs is there
                self._outputs[key] = self._node(self._of(block).outputs[name])
                on_path.pop()
                stack.pop()
                continue
            if (block, name) in on_path:
                loop = [*on_path[on_path.index((block, name)) :], (block, name)]
                text = (
                    f"algebraic loop: {' needs '.join(f'{b.name}.{n}' for b, n in loop)}; a lag, "
                    "an integrator or a delay in the loop opens it"
                )
                raise InputError(Problem(f"{block.kind} {block.name!r}", text))
            on_path.append((block, name))
            for leaf in leaves_of([self._of(block).outputs[name]]):
                if leaf.operation in ("state", "output", "named"):
                    other, part = self._target(leaf)
                    kept = part in other.starts or part in other.memories
                    if not kept and (id(other), part) not in self._outputs:
                        stack.append((other, part))

    def _differentiate(self) -> None:
        n, m = len(self.states), len(self.coordinates)
        first = {"state": 0, "value": n, "rate": n + m}
        rows = [*enumerate(self.rates), *((n + k, node) for k, node in self.pushes)]
        kept = [x for one in self.kept for x in (*one.updates, one.margin) if x is not None]
        kept += [x for one in self.delays for x in (one.input, one.slope) if x is not None]
        found = [node for _, node in self.openings]
        roots = [*self.rates, *(x for _, x in self.pushes), *self.seen, *kept, *found]
        self._values = self.program.below(roots)
        jacobian = self.program.jacobian([node for _, node in rows])
        self.slopes = [
            (row, first[kind] + index, slope)
            for (row, _), found in zip(rows, jacobian, strict=True)
            for (kind, index), slope in found.items()
        ]

    def _lay_out(self) -> None:
        """Give every entry a register: numbers, leaves, then results in order."""
        nodes = self.program.nodes
        used = sorted(self._values) + sorted(
            self.program.below(node for *_, node in self.slopes) - self._values
        )
        numbers = [k for k in used if nodes[k][0] == "number"]
        self.gravity = 3 if any(nodes[k][0] == "gravity" for k in used) else 0
        self.constants: list[Any] = [nodes[k][1] for k in numbers]
        self.register = {k: i for i, k in enumerate(numbers)}
        for k in used:
            kind, of = nodes[k]
            if kind == BLOCK:  # the register of its first number stands for a table
                self.register[k] = len(self.constants)
                self.constants += self.program.tables[cast(int, of)]
        sizes = {
            "state": len(self.states),
            "value": len(self.coordinates),
            "rate": len(self.coordinates),
            "time": 1,
            "signal": len(self.signals),
            "signal rate": len(self.signals),
            "memory": self.memories,
            "gravity": self.gravity,
        }
        at = len(self.constants)
        first = {}
        for kind in LEAVES:
            first[kind] = at
            at += sizes[kind]
        numbers_of = kinds("jo_do")
        self.code: list[int] = []
        self.values = 0
        for k in used:
            kind, of = nodes[k]
            if kind in first:
                assert isinstance(of, int)
                self.register[k] = first[kind] + of
            elif isinstance(of, tuple):
                self.register[k] = at
                at += 1
                operands = [self.register[part] for part in of]
                self.code += [numbers_of[kind], *operands, *(3 - len(operands)) * [operands[0]]]
                self.values += k in self._values


def systems_of(blocks: Sequence[Block], watched: Sequence[Expression]) -> list[System]:
    """Return the systems of the blocks of a mechanism; those that do not meet are separate.

    Raises
    ------
    InputError
        If an expression refers to a block that is not among them, or outputs form a loop.
    """
    leader = {id(block): id(block) for block in blocks}
    named = {block.name: block for block in blocks}

    def root(key: int) -> int:
        while leader[key] != key:
            leader[key] = leader[leader[key]]
            key = leader[key]
        return key

    def meet(key: int, roots: Iterable[Expression], where: str) -> None:
        for leaf in leaves_of(roots):
            if leaf.operation not in ("state", "output", "named"):
                continue
            of, part = leaf.of
            other = named.get(of) if leaf.operation == "named" else of
            if other is None:
                raise InputError(Problem(where, f"no block {of!r}{suggest(of, named)}"))
            if id(other) not in leader:
                raise InputError(
                    Problem(where, f"needs the block {other.name!r}, which is not in the mechanism")
                )
            known = (*other.starts, *other.memories, *other.outputs)
            if part not in known:
                text = f"needs {part!r} of block {other.name!r}{suggest(part, known)}"
                raise InputError(Problem(where, text))
            leader[root(id(other))] = root(key)

    for block in blocks:
        meet(id(block), block.checked().roots, f"{block.kind} {block.name!r}")
    for one in watched:
        leader[id(one)] = id(one)
        meet(id(one), [one], "sensor")
    members: dict[int, tuple[list[Block], list[Expression]]] = {}
    for block in blocks:
        members.setdefault(root(id(block)), ([], []))[0].append(block)
    for one in watched:
        members.setdefault(root(id(one)), ([], []))[1].append(one)
    return [System(i, *some) for i, some in enumerate(members.values())]
