"""Program: a model in C, with its constants and the names of its variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.version import __version__
from jousto.export import sources
from jousto.export.constants import Constants, array, constants, number, text
from jousto.export.ports import Named, Port, Ports, identifier, ports, refuse
from jousto.model.model import Model
from jousto.model.native.library import ffi
from jousto.model.native.native import Engine
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.solvers.base import Solver, prepared
from jousto.simulation.solvers.bounded_work import check_bounded
from jousto.simulation.solvers.default_solver import choose_fixed
from jousto.simulation.state import State, put

FIELDS = (
    *("method", "projection", "step", "alpha", "beta", "alpha_m", "alpha_f", "newmark_beta"),
    *(
        "newmark_gamma",
        "tolerance",
        "error_share",
        "absolute",
        "largest",
        "first",
        "iterations",
        "modified",
    ),
    "plain_inertia",
    "step_ends",
)


@dataclass(frozen=True, eq=False)
class Program:
    """Model in C, without the sources of the engine.

    Attributes
    ----------
    name : str
        C identifier, prefix of its names.
    model : Model
    solver : Solver
        Method of fixed step.
    constants : Constants
    ports : Ports
    bytes : int
        Memory of one machine on a 64-bit computer, bytes.
    """

    name: str
    model: Model
    solver: Solver
    constants: Constants
    ports: Ports
    bytes: int
    fields: dict[str, Any]
    states: Array
    named: tuple[Named, ...] = ()

    @property
    def source(self) -> str:
        """Text of the C file with all constants and one ``const jo_plant NAME_plant``."""
        p, m = self.ports, self.model
        solver = ", ".join(f".{key} = {_value(x)}" for key, x in self.fields.items())
        pieces = [
            f"/* {self.name}: the constants of a machine, written by jousto {__version__}. */",
            '#include "machine.h"',
            "#include <math.h>\n",
            self.constants.text,
            f"static const jo_solver solver = {{{solver}}};\n",
            array("q0", m.q0) if m.nq else "static const jo_real q0[1] = {0.0};\n",
            array("v0", m.v0) if m.nv else "static const jo_real v0[1] = {0.0};\n",
            *([array("x0", self.states)] if m.nstate else []),
        ]
        rows = {}
        for kind, found in (
            ("inputs", p.inputs),
            ("outputs", p.outputs),
            ("parameters", p.parameters),
        ):
            rows[kind] = "0"
            if found:
                lines = ",\n".join(f"    {_port(x)}" for x in found)
                pieces.append(f"static const jo_port {kind}[{len(found)}] = {{\n{lines}\n}};\n")
                rows[kind] = kind
        links = [
            f"    {{{k}, {place}, {number(factor)}, {number(offset)}}}"
            for k, one in enumerate(self.named)
            for place, factor, offset in one.links
        ]
        if links:
            body = ",\n".join(links)
            pieces.append(f"static const jo_named_link links[{len(links)}] = {{\n{body}\n}};\n")
        pieces.append(
            f"const jo_plant {self.name}_plant = {{\n"
            f"    .name = {text(m.name)},\n"
            "    .model = &model,\n    .solver = &solver,\n    .q0 = q0,\n    .v0 = v0,\n"
            f"    .x0 = {'x0' if m.nstate else '0'},\n"
            f"    .ntunable = {len(self.constants.tunable)},\n    .tunable = tunable,\n"
            f"    .ninput = {len(p.inputs)}, .noutput = {len(p.outputs)}, "
            f".nparameter = {len(p.parameters)},\n"
            f"    .input = {rows['inputs']}, .output = {rows['outputs']}, "
            f".parameter = {rows['parameters']},\n"
            f"    .nlink = {len(links)}, .link = {'links' if links else '0'}\n}};\n"
        )
        return "\n".join(pieces)

    @property
    def header(self) -> str:
        """Text of the header: names of inputs, outputs and parameters, units, and memory."""
        upper = self.name.upper()
        pieces = [
            f"/* {self.name}.h - {self.model.name}: names of its inputs, outputs and parameters.",
            " * Numbers are in SI units; angles in rad. See machine.h for the functions. */",
            f"#ifndef {upper}_H\n#define {upper}_H\n",
            '#include "machine.h"\n',
            f"extern const jo_plant {self.name}_plant;\n",
            f"#define {upper}_STEP {number(self.solver.step)}   /* s, {self.solver.step:g} */",
            f"#define {upper}_BYTES {self.bytes}   /* of memory for one machine, at most */\n",
        ]
        for word, found in (
            ("input", self.ports.inputs),
            ("output", self.ports.outputs),
            ("parameter", self.ports.parameters),
        ):
            names = [f"{self.name}_{word}_{x.symbol}" for x in found]
            lines = [
                f"    {name} = {k},   /* {_comment(x)} */"
                for k, (name, x) in enumerate(zip(names, found, strict=True))
            ]
            lines.append(f"    {self.name}_{word}s = {len(found)}")
            pieces.append("enum {\n" + "\n".join(lines) + "\n};\n")
        pieces.append("#endif\n")
        return "\n".join(pieces)


def program(
    model: Model,
    solver: Solver | None = None,
    *,
    state: State | None = None,
    name: str = "",
    named: Sequence[Named] = (),
) -> Program:
    """Return a model as a C program.

    Parameters
    ----------
    model : Model
        From `compile`.
    solver : Solver, optional
        Method of fixed step; None: the choice of `simulate` for 10 s: ``ROS2``, whose work per
        step is bounded, with 1 ms or less, or `GeneralizedAlpha` for stiffer machines.
    state : State, optional
        Initial positions and velocities; None: the initial state of the model.
    name : str
        Prefix of the names in C; empty is the name of the mechanism.
    named : sequence of Named
        Named constants that become parameters, from `named_constants`.

    Raises
    ------
    InputError
        For functions of Python in the model, and for adaptive methods.
    """
    chosen: Solver = choose_fixed(model) if solver is None else solver
    if chosen.adaptive:
        raise InputError(
            Problem(
                "export",
                f"{type(chosen).__name__} chooses its steps itself; an exported program needs a "
                "method of fixed step, such as ROS2(step=1e-3)",
            )
        )
    refuse(model)
    check_bounded(model, chosen)
    if not chosen.joint_coordinates:
        model = replace(model, tree=())
    engine = Engine(model)
    if (begun := initial_state(model, state)) is not None:
        put(engine, begun, "export")
        model = replace(model, q0=engine.q.copy(), v0=engine.v.copy())
    native = prepared(engine, chosen, chosen.step)
    fields = {key: getattr(native, key) for key in FIELDS}
    found = constants(engine, [one.value for one in named])
    size = _bytes(engine, found)
    return Program(
        _own_name(identifier(name or model.name)),
        model,
        chosen,
        found,
        ports(model, found, named),
        size,
        fields,
        engine.states.copy(),
        tuple(named),
    )


KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long main register restrict return short signed sizeof static struct switch "
    "typedef union unsigned void volatile while".split()
)


def _own_name(name: str) -> str:
    """Return a C identifier that is neither a keyword nor the name of another exported file."""
    files = {Path(key).stem for key in (*sources.headers(), *sources.engine())}
    taken = files | sources.hosted() | KEYWORDS
    return f"{name}_model" if name in taken or name.startswith("jo_") else name


def _bytes(engine: Engine, found: Constants) -> int:
    """Return an upper bound of the memory of a machine, bytes, see lay_out of machine.c.

    Vectors of a tree have three or four numbers, depending on the compiler options; the bound adds
    a third to their size here.
    """
    size, m = ffi().sizeof, engine.model
    structs = len(m.forces) * size("jo_force") + len(m.signals) * size("jo_signal")
    structs += len(m.frictions) * size("jo_friction") + size("jo_model") + size("jo_solver")
    vectors = engine.bytes - engine.bytes_without_tree
    total = engine.bytes + vectors // 3 + 8 * len(found.tunable) + structs + 1024
    return int(-(-total // 64) * 64)


def _value(x: Any) -> str:
    return number(x) if isinstance(x, float) else str(int(x))


def _port(port: Port) -> str:
    words = ", ".join(text(x) for x in (port.name, port.unit, port.about))
    return f"{{{words}, {port.place}, {number(port.start)}}}"


def _comment(port: Port) -> str:
    unit = "" if port.unit == "1" else f" ({port.unit})"
    start = (
        ""
        if port.start == 0.0
        else f", at first {np.format_float_positional(port.start, 6, trim='-', fractional=False)}"
    )
    return f"{port.name}{unit}: {port.about}{start}".replace("*/", "* /")
