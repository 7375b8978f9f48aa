"""Layout: a Model as the structs of jousto.h, with padded and blocked arrays."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.model.loop_joints import loops_of
from jousto.model.model import Model
from jousto.model.native.callback import callback
from jousto.model.native.damage_meter import meter_size, native_rule
from jousto.model.native.header import columns, kinds, packed
from jousto.model.native.memory_image import Laid, address
from jousto.model.native.numbers import force_numbers, padded_array, write_numbers
from jousto.model.newton_pattern import NewtonPattern, newton_pattern

Records: TypeAlias = NDArray[Any]  # structs in NumPy's view of their memory

NO_PATTERN = NewtonPattern((), (), (), (0,), (), 0)
CHUNK = 4096  # number of scalars that are allocated together


Build: TypeAlias = tuple[int, bool]  # build of the engine; whether Newton's pattern is included

_LAID: WeakKeyDictionary[Model, dict[Build, Laid]] = WeakKeyDictionary()
_BASE: WeakKeyDictionary[Model, dict[Build, Laid]] = WeakKeyDictionary()
_LIKE: WeakKeyDictionary[Model, Model] = WeakKeyDictionary()
# records of a model that a layout contains besides the links of a tree
RECORDS = (
    *(
        "bodies",
        "beams",
        "markers",
        "coordinates",
        "joints",
        "signals",
        "forces",
        "frictions",
        "switched",
    ),
    *("events", "sensors", "meters", "elimination", "size", "active"),
)


def share_layout(made: Model, model: Model) -> None:
    """Let a model take over the layout of a model that differs in its links and state only."""
    if made is not model and all(getattr(made, x) is getattr(model, x) for x in RECORDS):
        _BASE[made] = _LAID.get(model, {})


def lay_out_like(made: Model, model: Model) -> None:
    """Let a model take over the layout of a model that differs in numbers only.

    The numbers are written into a copy of that memory for the first engine of the model.
    """
    _LIKE[made] = model


class Layout:
    """Constants of one model in the memory of the engine.

    They are laid out once per model; its engines share them, except gravity.

    Parameters
    ----------
    library, ffi : cffi library and its view of the header
        The build of the engine.
    model : Model
        The mechanism.
    dtype : numpy dtype
        Scalars of the build, float64 or complex128.
    override : dict
        Arrays that replace those of the model, by name, see `Engine`.
    strict : bool
        Whether a singular position is an error.
    implicit : bool
        Whether the pattern of Newton's matrix is included; it always is for beams.

    Attributes
    ----------
    model : cffi pointer
        The jo_model; it lives as long as this object.
    raised : list of exceptions
        Exceptions of Python functions of the user during a call of the engine.
    laid : Laid
        The memory that the engines of the model share.
    """

    laid: Laid

    def __init__(
        self,
        library: Any,
        ffi: Any,
        model: Model,
        dtype: np.dtype[Any],
        override: dict[tuple[str, int, str], Any],
        strict: bool,
        implicit: bool = True,
    ) -> None:
        self._library = library
        self._ffi = ffi
        self._source = model
        self._dtype = dtype
        self._override = override
        self._strict = strict
        self._implicit = implicit or bool(model.beams)
        self._keep: list[Any] = []
        self._shared: dict[int, tuple[Any, Any]] = {}
        self._room, self._used = np.zeros(0, dtype), 0
        self._start, self._address = 0, ffi.NULL
        self._stride = dtype.itemsize // ffi.sizeof("jo_real")
        self.raised: list[BaseException] = []
        self.counts: dict[int, int] = {}  # structs or numbers at each address
        self.model = self._native_model()

    def _native_model(self) -> Any:
        """Return the jo_model; an existing engine of the model shares its constants."""
        m = self._source
        # user functions report exceptions to one engine, and may refer to the model
        own = bool(self._override) or any(force.function is not None for force in m.forces)
        known = {} if own else _LAID.setdefault(m, {})
        build = id(self._library), self._implicit
        laid = known.get(build)
        if laid is None:
            laid = known[build] = self._new() if own else self._similar() or self._new()
            self._room = np.zeros(0, self._dtype)
        self.laid = laid
        self._keep, self.counts = [laid], {}
        model = self._ffi.new("jo_model *", laid.model[0])
        model.redundant = -1 if self._strict else int(m.redundant)
        gravity = self._override.get(("model", 0, "gravity"), m.gravity)
        self._gravity = np.array(gravity, dtype=self._dtype)
        model.gravity = self._ffi.cast("jo_real *", address(self._gravity))
        return model

    def _new(self) -> Laid:
        """Return the memory of the model, laid out from its records."""
        return Laid(self._laid_out(), self._keep, self.counts)

    def _similar(self) -> Laid | None:
        """Return memory taken over from another model, see `lay_out_like` and `share_layout`."""
        m = self._source
        base = _BASE.get(m) or _LAID[m]
        plain = base.get((id(self._library), True)) or base.get((id(self._library), False))
        real = self._dtype == np.float64  # numbers of the complex build are laid out anew
        if real and (other := _LIKE.get(m)) is not None:
            theirs = self._laid_of(other)
            if plain is not None and theirs.extends:
                return theirs.on(plain)
            laid = theirs.image.copy()
            write_numbers(laid, other, m, self._library.JO_PAD)
            return laid
        return None if plain is None or m.mixed else self._extended(plain)

    def _laid_of(self, other: Model) -> Laid:
        """Return the memory of another model for the same build."""
        known = _LAID.get(other, {}).get((id(self._library), self._implicit))
        if known is not None:
            return known
        options = self._strict, self._implicit
        return Layout(self._library, self._ffi, other, self._dtype, {}, *options).laid

    def _extended(self, base: Laid) -> Laid:
        """Return the memory of a model without links, with the links of this model."""
        model = self._ffi.new("jo_model *", base.model[0])
        model.coordinate = self._coordinates()
        self._link(model)
        if not model.nnode:
            self._newton(model)
        return Laid(model, self._keep, self.counts, base)

    def count(self, pointer: int) -> int:
        """Return the number of structs or numbers at an address of the model."""
        if pointer == address(self._gravity):
            return self._gravity.size
        return self.laid.count(pointer)

    def _constant(
        self, array: Any, key: tuple[str, int, str] | None = None, shared: Any = None
    ) -> Any:
        """Copy an array to the engine's scalar type and keep it alive; None becomes NULL.

        Arrays of the same object `shared` are copied once: bodies of one reduced part share memory,
        which saves cache.
        """
        if key is not None and key in self._override:
            array = self._override[key]
        if array is None:
            return self._ffi.NULL
        if shared is not None and id(shared) in self._shared:
            return self._shared[id(shared)][1]
        flat = np.asarray(array, dtype=self._dtype).ravel()
        pointer = self._place(flat) if flat.size else self._ffi.NULL
        if shared is not None:
            self._shared[id(shared)] = (shared, pointer)
        return pointer

    def _cast(self, struct: str, array: Any, key: tuple[str, int, str]) -> Any:
        """Return the array of `_constant` as a pointer to structs."""
        return self._ffi.cast(f"{struct} *", self._constant(array, key))

    def _place(self, flat: NDArray[Any]) -> Any:
        """Copy an array behind the previous one; large ones start on a cache line."""
        size = self._dtype.itemsize
        line = 64 // size
        if flat.size >= 2 * line:
            self._used += -self._used % line
        if not self._room.size or self._used + flat.size > self._room.size:
            count = max(CHUNK, flat.size)
            raw = np.zeros((count + line) * size, np.uint8)
            start = -raw.ctypes.data % 64
            self._room = raw[start : start + count * size].view(self._dtype)
            self._used = 0
            self._start = int(self._room.ctypes.data)
            self._address = self._ffi.cast("jo_real *", self._start)
            self._keep.append(self._room)
        self._room[self._used : self._used + flat.size] = flat
        self.counts[self._start + self._used * size] = flat.size
        pointer = self._address + self._used * self._stride
        self._used += flat.size
        return pointer

    def _count(self, pointer: Any, count: int) -> None:
        self.counts[int(self._ffi.cast("uintptr_t", pointer))] = count

    def _structs(self, kind: str, count: int) -> Any:
        array = self._ffi.new(f"{kind}[]", max(count, 1))
        self._keep.append(array)
        self._count(array, count)
        return array

    def _laid_out(self) -> Any:
        m = self._source
        model = self._ffi.new("jo_model *")
        sides = self._sides()
        pairs, pulls = self._pairs(sides), self._pulls(sides)
        updates = [u for column in m.elimination.updates for u in column]
        belows = [b for column in m.elimination.below for b in column]
        sizes = {
            "nbody": len(m.bodies),
            "nbeam": len(m.beams),
            "nmarker": len(m.markers),
            "nactive": m.active,
            "ncoordinate": len(m.coordinates),
            "njoint": len(m.joints),
            "nline": sum(len(joint.lines) for joint in m.joints),
            "npair": len(pairs),
            "nhub": len(m.elimination.hubs),
            "npull": len(pulls),
            "ncolumn": len(m.elimination.order),
            "nblock": m.elimination.count,
            "nsignal": len(m.signals),
            "nforce": len(m.forces),
            "nfriction": len(m.frictions),
            "nswitched": len(m.switched),
            "nevent": len(m.events),
            "nsensor": len(m.sensors),
            "nturn": sum(c.kind == "angle" for c in m.coordinates),
            "nlock": sum(joint.lock >= 0 for joint in m.joints),
            "ninput": len(m.inputs),
            "nstate": m.nstate,
            "nyielding": sum(force.law.yields for force in m.forces),
            "nbreak": len(m.breaks),
            "nmeter": len(m.meters),
            "nmemory": sum(meter_size(meter.rule) for meter in m.meters),
            "nq": m.nq,
            "nv": m.nv,
            "nrow": m.nrow,
            "nout": m.nout,
        }
        for name, size in sizes.items():
            setattr(model, name, size)
        model.size = m.size
        model.breaks = self._constant(m.breaks)
        model.body = self._bodies()
        model.beam = self._beams()
        model.marker = self._markers()
        model.coordinate = self._coordinates()
        model.joint = self._joints()
        model.line = self._lines()
        model.pair = self._fill("jo_pair", pairs)
        model.pull = self._fill("jo_pull", pulls)
        starts = np.cumsum([0, *(len(c) for c in m.elimination.below)])
        columns = [
            (joint, int(starts[c]), len(m.elimination.below[c]))
            for c, joint in enumerate(m.elimination.order)
        ]
        model.column = self._fill("jo_column", columns)
        model.below = self._fill("jo_below", belows)
        model.update = self._fill("jo_update", updates)
        first = np.cumsum([0, *(len(c) for c in m.elimination.updates)])
        model.update_first = self._fill("int", [int(i) for i in first])
        model.signal = self._signals()
        model.force = self._forces()
        model.friction = self._frictions()
        model.switched = self._switched()
        model.event = self._copied("jo_event", m.events)
        model.sensor = self._sensors()
        model.meter = self._meters()
        self._link(model)
        self._newton(model)
        return model

    def _link(self, model: Any) -> None:
        """Lay out the links of a tree and the loops between them."""
        m, loops = self._source, loops_of(self._source)
        model.nlink, model.nx, model.nu = len(m.links), m.nx, m.nu
        model.nloop, model.nreach = len(loops.loops), len(loops.reaches)
        model.nmeet = len(loops.meets)
        model.link = self._copied("jo_link", m.links)
        model.loop = self._fill("jo_loop", loops.loops)
        model.reach = self._fill("jo_reach", loops.reaches)
        model.meet = self._fill("jo_meet", loops.meets)

    def _newton(self, model: Any) -> None:
        """Lay out the pattern of Newton's matrix, empty without implicit methods."""
        newton = NO_PATTERN
        if self._implicit:
            newton = newton_pattern(self._source)
        model.nnode, model.nnewton = len(newton.nodes), newton.reals
        model.node = self._fill("jo_node", list(newton.nodes))
        model.branch = self._fill("jo_branch", list(newton.branches))
        model.fill = self._fill("jo_fill", list(newton.fills))
        model.fill_first = self._fill("int", list(newton.first))
        model.place = self._fill("jo_place", list(newton.places))

    def _copied(self, kind: str, objects: Sequence[Any], more: int = 0) -> Any:
        """Return structs filled from objects, by equal names; `kind` selects the types.

        `more` empty structs follow.
        """
        array = self._structs(kind, len(objects) + more)
        records = self._records(array, objects)
        fields = self._ffi.typeof(kind).fields
        types = kinds(f"{kind}_type") if fields[0][0] == "type" else {}
        for name, field in fields if objects else ():
            if name == "type":
                records[name] = [types[source.kind] for source in objects]
            elif field.type.kind == "primitive" and hasattr(objects[0], name):
                records[name] = [getattr(source, name) for source in objects]
        return array

    def _records(self, structs: Any, objects: Sequence[Any]) -> Records:
        """Return the memory of the structs of objects, filled field by field."""
        layout = columns(self._ffi.typeof(structs).item.cname)
        return np.frombuffer(self._ffi.buffer(structs), layout)[: len(objects)]

    def _refer(
        self, records: Records, kind: str, names: Sequence[str], sources: Sequence[Any]
    ) -> None:
        """Copy arrays of the objects consecutively, and set the pointers of their structs.

        All arrays with the same name have the same size; `kind` is the name of the objects in
        `override`.
        """
        if not sources:
            return
        rows = []
        for name in names:
            arrays = [getattr(source, name) for source in sources]
            for i in range(len(sources)) if self._override else ():
                arrays[i] = self._override.get((kind, i, name), arrays[i])
            rows.append(np.array(arrays, dtype=self._dtype).reshape(len(sources), -1))
        block = np.concatenate(rows, axis=1)
        size = self._dtype.itemsize
        self._place(block.ravel())
        first = self._start + (self._used - block.size) * size
        starts = first + np.arange(len(sources)) * (block.shape[1] * size)
        for name, row in zip(names, rows, strict=True):
            records[name] = starts
            self.counts.update(dict.fromkeys(starts.tolist(), row.shape[1]))
            starts = starts + row.shape[1] * size

    def _fill(self, kind: str, values: Sequence[Any]) -> Any:
        """Return structs of ints, or plain ints, with given values."""
        array = self._structs(kind, len(values))
        if len(values):
            rows = chain.from_iterable(values) if isinstance(values[0], tuple) else values
            width = self._ffi.sizeof(kind) // self._ffi.sizeof("int")
            ints = np.fromiter(rows, np.intc, len(values) * width)
            self._ffi.buffer(array)[:] = ints.tobytes()
        return array

    def _sides(self) -> dict[int, list[tuple[int, int]]]:
        """Return the joints and their sides on each moving body."""
        m = self._source
        sides: dict[int, list[tuple[int, int]]] = {}
        for k, joint in enumerate(m.joints):
            for side, marker in enumerate(joint.sides):
                if m.markers[marker].body >= 0:
                    sides.setdefault(m.markers[marker].body, []).append((k, side))
        return sides

    def _pulls(self, sides: dict[int, list[tuple[int, int]]]) -> list[tuple[int, int, int, int]]:
        """Return joint sides on hubs and the blocks of joint and hub to which they contribute."""
        m, found = self._source, []
        place = {item: c for c, item in enumerate(m.elimination.order)}
        for i, body in enumerate(m.elimination.hubs):
            hub = len(m.joints) + i
            for k, side in sides[body]:
                later = place[k] > place[hub]
                block = m.elimination.blocks[(k, hub) if later else (hub, k)]
                found.append((k, side, block, int(later)))
        return found

    def _pairs(
        self, sides: dict[int, list[tuple[int, int]]]
    ) -> list[tuple[int, int, int, int, int]]:
        """Return pairs of joint sides on one body and the block of S to which they contribute."""
        m = self._source
        place = {joint: c for c, joint in enumerate(m.elimination.order)}
        pairs = []
        for body in sorted(sides.keys() - set(m.elimination.hubs)):
            for k, side_k in sides[body]:
                for j, side_j in sides[body]:
                    if place[k] >= place[j]:
                        pairs.append((k, side_k, j, side_j, m.elimination.blocks[k, j]))
        if m.mixed:  # pairs of joints that are not links come first
            inside = {place for link in m.links for place in (link.joint, link.drive)}
            pairs.sort(key=lambda pair: pair[0] in inside or pair[2] in inside)
        return pairs

    def _bodies(self) -> Any:
        pad, rows_d, rows_b, dense = (
            getattr(self._library, name) for name in ("JO_PAD", "JO_ROW_D", "JO_ROW_B", "JO_DENSE")
        )
        bodies = self._source.bodies
        structs = self._copied("jo_body", bodies)
        records = self._records(structs, bodies)
        records["np"] = -(-records["n"] // pad) * pad
        self._refer(records, "body", ("mass", "S0", "J0"), bodies)
        for i in np.flatnonzero(records["np"]).tolist():
            b, body = structs[i], bodies[i]
            for name in ("I3", "B0", "D0", "K", "D"):
                array = self._override.get(("body", i, name), getattr(body, name))
                setattr(
                    b, name, self._constant(padded_array(np.asarray(array), b.np), shared=array)
                )
            for name, rows in (("ED", rows_d), ("EB", rows_b)):
                array = self._override.get(("body", i, name), getattr(body, name))
                setattr(
                    b,
                    name,
                    self._constant(_blocked(np.asarray(array), b.np, rows, dense), shared=array),
                )
        return structs

    def _beams(self) -> Any:
        structs = self._copied("jo_beam", self._source.beams)
        for i, beam in enumerate(self._source.beams):
            structs[i].data = self._cast("jo_beam_data", beam.data, ("beam", i, "data"))
        return structs

    def _markers(self) -> Any:
        markers, bodies = self._source.markers, self._source.bodies
        structs = self._copied("jo_marker", markers)
        self._refer(self._records(structs, markers), "marker", ("u0", "A0"), markers)
        modal = {i for i, body in enumerate(bodies) if body.n}
        for i, marker in enumerate(markers) if modal else ():
            if marker.body not in modal:
                continue
            s, n, pad = structs[i], bodies[marker.body].n, self._library.JO_PAD
            np_ = -(-n // pad) * pad
            for name in ("Phi", "Psi"):
                shapes = self._override.get(("marker", i, name), getattr(marker, name))
                padded = None if shapes is None else padded_array(np.asarray(shapes), np_)
                setattr(s, name, self._constant(padded))
            if marker.chi is not None:
                chi = self._override.get(("marker", i, "chi"), marker.chi)
                s.chi = self._constant(padded_array(np.asarray(chi), np_))
        return structs

    def _coordinates(self) -> Any:
        coordinates = self._source.coordinates
        structs = self._copied("jo_coordinate", coordinates)
        records = self._records(structs, coordinates)
        records["turn"] = records["link"] = -1
        angles = np.array([c.kind == "angle" for c in coordinates], dtype=bool)
        records["turn"][angles] = np.arange(angles.sum())
        for i, link in enumerate(self._source.links):
            for place in link.coordinates:
                structs[place].link = i
        return structs

    def _lines(self) -> Any:
        lines = [(joint, line) for joint in self._source.joints for line in joint.lines]
        structs = self._copied("jo_line", [line for _, line in lines])
        for i, (joint, line) in enumerate(lines):
            s = structs[i]
            s.count = len(line.coordinates)
            for k, index in enumerate(line.coordinates):
                coordinate = self._source.coordinates[index]
                s.coordinate[k] = index
                pairs = list(zip(joint.sides[::2], joint.sides[1::2], strict=True))
                s.side[k] = 2 * pairs.index((coordinate.a, coordinate.b))
            factor = (*line.factors, 0.0)[:2]
            data = packed("jo_line_data", offset=line.offset, factor=factor)
            s.data = self._cast("jo_line_data", data, ("line", i, "data"))
        return structs

    def _joints(self) -> Any:
        hubs = self._source.elimination.hubs
        joints = self._source.joints
        structs = self._copied("jo_joint", joints, more=len(hubs))
        records = self._records(structs, joints)
        for i in range(len(hubs)):
            s = structs[len(joints) + i]
            s.nrow, s.lock, s.release = 6, -1, -1
            s.side[0] = s.side[1] = self._on_hub(hubs[i])  # body index for error messages
        records["nrow"] = [joint.rows for joint in joints]
        lines = np.array([len(joint.lines) for joint in joints], dtype=np.intc)
        records["nline"], records["line"] = lines, np.cumsum(lines) - lines
        pairs = [joint.perpendicular for joint in joints]
        records["nside"] = _filled(records["side"], [joint.sides for joint in joints])
        records["nperp"] = _filled(records["perp_a"], [[a for a, _ in some] for some in pairs])
        _filled(records["perp_b"], [[b for _, b in some] for some in pairs])
        return structs

    def _on_hub(self, body: int) -> int:
        """Return a marker on a body that is a hub."""
        return next(i for i, marker in enumerate(self._source.markers) if marker.body == body)

    def _signals(self) -> Any:
        structs = self._copied("jo_signal", self._source.signals)
        for i, signal in enumerate(self._source.signals):
            s = structs[i]
            s.child[0], s.child[1] = signal.children
            s.data = self._constant(signal.data, ("signal", i, "data"))
        return structs

    def _forces(self) -> Any:
        structs = self._copied("jo_force", self._source.forces)
        for i, force in enumerate(self._source.forces):
            s = structs[i]
            data = force_numbers(force, self._source, self._library.JO_PAD)
            s.data = self._constant(data, ("force", i, "data"))
            if force.function is not None:
                s.function, s.user, kept = callback(self._ffi, force.function, self.raised)
                self._keep.append(kept)
        return structs

    def _frictions(self) -> Any:
        structs = self._copied("jo_friction", self._source.frictions)
        for i, friction in enumerate(self._source.frictions):
            s = structs[i]
            s.law = int(friction.sticks)
            s.data = self._cast("jo_friction_data", friction.data, ("friction", i, "data"))
        return structs

    def _switched(self) -> Any:
        structs = self._copied("jo_switched", self._source.switched)
        for i, row in enumerate(self._source.switched):
            structs[i].data = self._cast("jo_limits_data", row.data, ("switched", i, "data"))
        return structs

    def _sensors(self) -> Any:
        structs = self._copied("jo_sensor", self._source.sensors)
        for i, sensor in enumerate(self._source.sensors):
            if sensor.rows is not None:
                pad, n = self._library.JO_PAD, sensor.rows.shape[-1]
                structs[i].rows = self._constant(padded_array(sensor.rows, -(-n // pad) * pad))
        return structs

    def _meters(self) -> Any:
        structs = self._structs("jo_meter", len(self._source.meters))
        at = 0
        for i, meter in enumerate(self._source.meters):
            structs[i] = native_rule(self._ffi, meter.rule)[0]
            structs[i].output, structs[i].factor, structs[i].at = meter.output, meter.factor, at
            at += meter_size(meter.rule)
        return structs


def _blocked(E: NDArray[Any], padded_n: int, rows: int, dense: int) -> NDArray[Any]:
    """Return E (c, j, k) in the order of jousto.h: blocks of rows, or tiles for large n."""
    n = E.shape[2]
    if n == 0:
        return E
    if padded_n <= dense:
        padded = np.zeros((E.shape[0], padded_n, n), E.dtype)
        padded[:, :n] = E
        return np.ascontiguousarray(padded.reshape(-1, rows, n).swapaxes(1, 2))
    padded = np.zeros((E.shape[0], padded_n, padded_n), E.dtype)
    padded[:, :n, :n] = E
    count = padded_n // 4
    tiles = padded.reshape(-1, count, 4, count, 4).transpose(0, 3, 1, 4, 2)  # c, kb, jb, k, j
    kb, jb = np.triu_indices(count)
    return np.ascontiguousarray(tiles[:, kb, jb])


def _filled(out: NDArray[np.intc], rows: Sequence[Sequence[int]]) -> list[int]:
    """Write rows of numbers to the beginnings of the rows of `out`; return their lengths."""
    for k in range(out.shape[1]):
        out[:, k] = [row[k] if k < len(row) else 0 for row in rows]
    return [len(row) for row in rows]
