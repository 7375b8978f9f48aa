"""advise: choice of the modes of a part by their number and accuracy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.base.object_repr import described
from jousto.certificate.basis_families import (
    Family,
    family_of,
    frequency_errors,
    load_errors,
    modes_below,
    spectrum,
)
from jousto.certificate.certificate import Table, number
from jousto.certificate.certify import full_model
from jousto.certificate.part_checks import FullModel
from jousto.reduction.methods import CraigBampton, FreeFree, Method
from jousto.reduction.sparse import factor
from jousto.reduction.stages import Report, Run, reporter

if TYPE_CHECKING:
    from jousto.parts.part import Part


REACH = (2.0, 4.0, 8.0)
"""Multiples of the frequency limit up to which fixed-interface modes are computed."""

LEAST = 3
"""Smallest number of proposed fixed-interface modes without a frequency limit."""


@described
@dataclass(frozen=True, eq=False)
class Advice:
    """Proposed modes with the reasons; ``print`` displays them.

    Parameters
    ----------
    method : CraigBampton or FreeFree
        Method for `reduce`.
    table : Table
        Accuracy for each number of modes.
    explanation : tuple of str
        Reasons, as sentences.
    reached : bool
        Whether the modes reach the requested accuracy.
    """

    method: Method
    table: Table
    explanation: tuple[str, ...]
    reached: bool = True

    def __str__(self) -> str:
        rows = self.table.lines()
        return "\n".join(
            [f"take {self.method!r}", *self.explanation, self.table.title, *rows, self.table.remark]
        )


@explained
def advise(
    part: Part,
    interfaces: Sequence[str] | str = (),
    *,
    frequency_limit: float | None = None,
    loads: Mapping[str, ArrayLike] | ArrayLike | None = None,
    accuracy: float = 0.01,
    solver: str | None = None,
    progress: bool | Report | None = None,
) -> Advice:
    """Return the modes that a part needs, and the accuracy with fewer and with more modes.

    Frequencies: all free-free modes of the full part up to the limit must be reproduced with the
    accuracy. They are computed for the full part and for the reduced part with 0, 1, 2 ...
    fixed-interface modes. Loads: the static displacement, and the stress if available, under each
    load with fixed interfaces must be reproduced with the accuracy; if this needs more modes than
    there are loads, residual vectors are proposed, which make it exact.

    Parameters
    ----------
    part : Part
        The free part.
    interfaces : sequence of str
        Node sets or interfaces where joints and forces act; empty for the interfaces of the part,
        or free-free modes if the part has none.
    frequency_limit : float, optional
        Highest frequency of interest, Hz.
    loads : mapping of str to (ndof,) array, or (ndof,) or (ndof, m) array, optional
        Nodal load patterns in the part's degrees of freedom, any unit.
    accuracy : float
        Largest allowed relative error of frequencies, largest displacement and largest stress.
    solver : str, optional
        Library of the factorisation, see `solvers`.
    progress : bool or function, optional
        True shows a bar for each stage; a function is called with (stage, finished fraction of it,
        0 to 1).

    Returns
    -------
    Advice
        Result with ``method`` for `reduce`. Loads on the interfaces need no further modes:
        constraint modes contain their static response exactly.

    Raises
    ------
    InputError
        If there is neither a limit nor loads, a value is wrong, the solver is unknown, or the part
        cannot be reduced.

    Examples
    --------
    >>> import jousto as jo
    >>> steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    >>> rod = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 10, steel, name="rod")
    >>> advice = advise(rod, ("start", "end"), frequency_limit=500.0)
    >>> advice.method.modes
    4
    >>> arm = jo.reduce(rod, advice.method)
    """
    names, patterns = _arguments(part, interfaces, frequency_limit, loads, accuracy)
    if solver is not None:
        factor.choose(part.K.shape[0], f"part '{part.name}'", solver)
    with reporter(progress) as report:
        return _advise(part, names, patterns, frequency_limit, accuracy, Run(solver, report))


def _advise(
    part: Part,
    names: tuple[str, ...],
    patterns: dict[str, Array],
    frequency_limit: float | None,
    accuracy: float,
    run: Run,
) -> Advice:
    full, faults = full_model(part, modes=0, run=run)
    if full is None or full.rigid is None or full.held is None or full.held.solve is None:
        raise InputError(
            Problem(f"part '{part.name}'", next(iter(faults.values()), "is too small"))
        )
    truth = None
    if frequency_limit is not None:
        truth = modes_below(full, frequency_limit, run)
    if not names:
        return _free(full, truth, frequency_limit)
    if frequency_limit is None:
        return _choose(family_of(full, names, None, run), truth, None, patterns, accuracy)
    for reach in REACH:
        family = family_of(full, names, reach * frequency_limit, run)
        advice = _choose(family, truth, frequency_limit, patterns, accuracy)
        if advice.reached:
            break
    return advice


def _arguments(
    part: object,
    interfaces: Sequence[str] | str,
    frequency_limit: float | None,
    loads: Any,
    accuracy: float,
) -> tuple[tuple[str, ...], dict[str, Array]]:
    from jousto.parts.part import Part

    if not isinstance(part, Part):
        message = f"part is {part!r}, must be a Part such as Part.beam(...)"
        raise InputError(Problem("advise", message))
    problems = Problems()
    names = (interfaces,) if isinstance(interfaces, str) else tuple(interfaces)
    names = names or tuple(tie.name for tie in part.ties)
    if frequency_limit is None and loads is None:
        problems.add("advise", "give frequency_limit=Hz or loads=patterns (or both)")
    if frequency_limit is not None and not (np.isfinite(frequency_limit) and frequency_limit > 0):
        problems.add("advise", f"frequency_limit is {frequency_limit:g} Hz, must be positive")
    if not 0.0 < accuracy < 1.0:
        problems.add("advise", f"accuracy is {accuracy:g}, must be between 0 and 1 such as 0.01")
    if loads is not None and not names:
        problems.add(
            "advise", "loads need interfaces that fix the part; give node sets of the part"
        )
    ndof = part.K.shape[0]
    patterns: dict[str, Array] = {}
    if isinstance(loads, Mapping):
        given = {str(name): value for name, value in loads.items()}
    elif loads is None:
        given = {}
    elif np.ndim(loads) == 2:
        given = {f"load {j + 1}": column for j, column in enumerate(np.asarray(loads).T)}
    else:
        given = {"load": loads}
    for name, value in given.items():
        array = problems.array("advise", name, value, (ndof,))
        if array is not None and not np.any(array):
            problems.add("advise", f"{name} is zero everywhere")
        elif array is not None:
            patterns[name] = array
    problems.raise_if_any()
    return names, patterns


def _free(full: FullModel, truth: tuple[Array, Array] | None, limit: float | None) -> Advice:
    assert truth is not None and limit is not None
    f = truth[0][truth[0] <= limit]
    rows = tuple((str(k + 1), number(x, 6)) for k, x in enumerate(f))
    if not len(f):
        message = (
            f"its lowest elastic mode, {number(truth[0][0])} Hz, lies above the frequency limit "
            f"{number(limit)} Hz: a RigidBody is enough"
        )
        raise InputError(Problem(f"part '{full.part.name}'", message))
    sentences = (
        f"The free part has {count(len(f), 'elastic mode')} up to {number(limit)} Hz.",
        "No interfaces are given: if joints or forces act on the part, give their nodes as "
        "interfaces and use CraigBampton, since free modes converge slowly there.",
    )
    table = Table("free-free modes", ("mode", "Hz"), rows)
    return Advice(FreeFree(modes=len(f)), table, sentences)


def _choose(
    family: Family,
    truth: tuple[Array, Array] | None,
    limit: float | None,
    patterns: dict[str, Array],
    accuracy: float,
) -> Advice:
    most = family.fixed.shape[1]
    errors = [np.zeros(most + 1)] if truth is None else [frequency_errors(family, truth)]
    bends, stresses = load_errors(family, patterns)
    dynamic = _first(errors[0] <= accuracy)
    static = [np.maximum(bends[name], stresses[name]) for name in patterns]
    loaded = _first(np.max(static, axis=0) <= accuracy) if static else 0
    least = 0 if limit is not None else min(LEAST, most)
    if dynamic is not None and limit is not None:
        # all fixed-interface modes below the limit are needed, since the supported body vibrates in
        # these
        dynamic = max(dynamic, int(np.sum(family.frequencies <= limit)))
    k = max(dynamic if dynamic is not None else most, least)
    use_residuals = bool(static) and (loaded is None or loaded > k + len(patterns))
    if static and not use_residuals and loaded is not None:
        k = max(k, loaded)
    names = tuple(name for name, _ in family.modes.interfaces)
    method = CraigBampton(names, modes=k)
    if use_residuals:
        method = replace(method, residuals=tuple(patterns.values()))
    reached = dynamic is not None
    sentences = _explain(
        family, truth, limit, accuracy, (k, dynamic, loaded), tuple(patterns), use_residuals
    )
    table = _table(family, errors[0] if truth is not None else None, bends, stresses, k)
    return Advice(method, table, sentences, reached)


def _first(good: NDArray[np.bool_]) -> int | None:
    """Return the smallest number of modes from which on all values are good."""
    bad = np.flatnonzero(~good)
    k = int(bad[-1]) + 1 if len(bad) else 0
    return k if k < len(good) else None


def _table(
    family: Family,
    frequency: Array | None,
    bends: dict[str, Array],
    stresses: dict[str, Array],
    chosen: int,
) -> Table:
    most = family.fixed.shape[1]
    shown = sorted({*(k for k in (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64) if k <= most)} | {
        chosen, max(chosen - 1, 0), most
    })  # fmt: skip
    columns = ["fixed modes", "up to (Hz)", "all modes"]
    if frequency is not None:
        columns.append("frequency error")
    for name in bends:
        columns.append(f"{name}: displacement")
        if family.full.part.stress is not None:
            columns.append(f"{name}: stress")
    rows = []
    for k in shown:
        row = [f"{k} <" if k == chosen else str(k)]
        row.append(number(family.frequencies[k - 1]) if k else "-")
        row.append(str(family.static.shape[1] - 6 + k))
        if frequency is not None:
            row.append(_error(frequency[k]))
        for name, error in bends.items():
            row.append(_error(error[k]))
            if family.full.part.stress is not None:
                row.append(_error(stresses[name][k]))
        rows.append(tuple(row))
    return Table(
        "accuracy by number of fixed-interface modes",
        tuple(columns),
        tuple(rows),
        "All modes: including the constraint modes of the interfaces, without rigid motions.",
    )


def _error(value: float) -> str:
    return "missing" if value >= 1.0 else f"{100.0 * value:.2g} %"


def _explain(
    family: Family,
    truth: tuple[Array, Array] | None,
    limit: float | None,
    accuracy: float,
    numbers: tuple[int, int | None, int | None],
    patterns: tuple[str, ...],
    use_residuals: bool,
) -> tuple[str, ...]:
    k, dynamic, loaded = numbers
    f = family.frequencies
    sentences = []
    goal = f"{100.0 * accuracy:g} %"
    if truth is not None and limit is not None:
        there = int(np.sum(truth[0] <= limit))
        if there:
            sentences.append(
                f"The free part has {count(there, 'elastic mode')} up to {number(limit)} Hz, from "
                f"{number(truth[0][0])} Hz."
            )
        else:
            rigid = "" if len(f) and f[0] <= limit else "; a RigidBody may be enough"
            sentences.append(
                f"The free part has no elastic mode up to {number(limit)} Hz: its lowest, "
                f"{number(truth[0][0])} Hz, is used instead{rigid}."
            )
        below = int(np.sum(f <= limit))
        if below:
            held = ", ".join(name for name, _ in family.modes.interfaces)
            sentences.append(
                f"Fixed at {held} it has {count(below, 'mode')} up to the limit, from "
                f"{number(f[0])} Hz."
            )
        if dynamic is None:
            sentences.append(
                f"With {count(len(f), 'fixed-interface mode')} the error {goal} is not yet "
                f"reached; refine the mesh, use fewer interface nodes, or accept a larger error."
            )
        elif dynamic:
            sentences.append(
                f"{count(dynamic, 'fixed-interface mode')}, up to {number(f[dynamic - 1])} Hz "
                f"({number(f[dynamic - 1] / limit, 2)} times the limit), and the constraint modes "
                f"of the interfaces reproduce all of them within {goal}."
            )
        else:
            sentences.append(
                f"The constraint modes of the interfaces alone reproduce it within {goal}."
            )
    else:
        sentences.append(
            f"No frequency limit is given: {count(k, 'mode')} up to {number(f[k - 1])} Hz are kept "
            "for vibration." if k else "No frequency limit is given."
        )  # fmt: skip
    if patterns and use_residuals:
        needs = "more modes than were tried" if loaded is None else count(loaded, "mode")
        sentences.append(
            f"Static accuracy of {goal} under {', '.join(patterns)} alone would need {needs}: "
            f"{count(len(patterns), 'residual vector')} instead "
            f"{'makes' if len(patterns) == 1 else 'make'} the static response exact."
        )
    elif patterns:
        sentences.append(
            f"Displacement and stress under {', '.join(patterns)} are reproduced within {goal} "
            f"with "
            f"{count(loaded or 0, 'mode')}."
            if family.full.part.stress is not None
            else f"Displacement under {', '.join(patterns)} is reproduced within {goal} with "
            f"{count(loaded or 0, 'mode')}; the part has no stress data to compare."
        )
    highest = float(spectrum(family, k)[0].max(initial=0.0))
    if highest:
        without = ", without residual vectors," if use_residuals else ""
        # stability of RK4 on the imaginary axis, h omega < 2.83
        step = 2.8 / (2.0 * np.pi * highest)
        sentences.append(
            f"The stiffest of the {family.static.shape[1] - 6 + k} modes{without} has "
            f"{number(highest)} Hz: RK4 would need steps below {number(step, 2)} s; the steps of "
            f"ROS2 and of the implicit methods depend on the motion only."
        )
    return tuple(sentences)
