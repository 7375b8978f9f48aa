"""Plastic hinges over a run: cycles of plastic deformation, shakedown, ratchet, strain life."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, suggest, warn
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.fatigue.cycles.rainflow import turning_points
from jousto.fatigue.local.strain_life import LocalCycles, Residue, loops
from jousto.materials.strength.strain_life import FORMS, Form, StrainLife
from jousto.mechanism.sensors.damage_rule import RESIDUES

STILL = 1e-6
"""Range of the plastic deformation in a cycle over that of the history, below which it is none."""
CLOSED = 1e-3
"""Drift of the plastic deformation in a cycle, over its range, below which its loop is closed."""
ROUND = 1e-9
"""Difference of moments over their range, up to which they are the same."""
TREND = 0.01
"""Decrease from cycle to cycle, over the value, from which on yielding dies away."""
UNLIKE = 2.0
"""Yielding in the last cycle over the largest of those before, above which they do not tell."""
LAST = 3
"""Most cycles by which a trend is judged."""
OPEN = 0.01
"""The same over the whole history, above which a repetition would start elsewhere."""


@described
@dataclass(frozen=True, eq=False)
class HingeCycles(Tabular):
    """Load cycles of a plastic hinge: how far it yields in each, and what becomes of it.

    Attributes
    ----------
    range : (n,) array
        Range of the plastic deformation in each cycle, largest minus smallest, rad or m.
    drift : (n,) array
        Plastic deformation at the end of each cycle minus that at its start, rad or m.
    work : (n,) array
        Plastic work in each cycle, J.
    largest : float
        Largest magnitude of the plastic deformation over the history.
    verdict : str
        "elastic": the hinge never yields; "shakedown": it yields at first, but not in the last
        cycle; "alternating": it yields in both directions, in a closed loop; "ratchet": in the last
        cycles the deformation grows in one direction; "settling": it yields less from cycle to
        cycle; "undecided": it yields in the last cycle, and too few cycles before are similar.
    """

    range: Array
    drift: Array
    work: Array
    largest: float
    verdict: str

    def table(self, rows: int = 10) -> str:
        """Return a table of the last cycles."""
        about = {
            "elastic": "it never yields",
            "shakedown": "no plastic deformation in the last cycle",
            "alternating": "the last cycle is a closed plastic loop: low-cycle fatigue",
            "ratchet": "in the last cycles the plastic deformation grows in one direction",
            "settling": "each of the last cycles yields less than the one before",
            "undecided": "too few cycles like the last one, in which it yields; give more cycles",
        }
        n = len(self.drift)
        last = f"; drift of the last cycle {self.drift[-1]:.4g}" if n else ""
        if n > 1:
            last += f", of the one before {self.drift[-2]:.4g}"
        lines = [
            f"plastic hinge, {len(self.range)} load cycles: {self.verdict}, "
            f"{about[self.verdict]}; largest deformation {self.largest:.6g}{last}",
            f"{'cycle':>6} {'range':>12} {'drift':>12} {'work':>12}",
        ]
        for k in range(max(0, len(self.range) - rows), len(self.range)):
            lines.append(
                f"{k + 1:6d} {self.range[k]:12.5g} {self.drift[k]:12.5g} {self.work[k]:12.5g}"
            )
        return "\n".join(lines)

    def _csv(self) -> Rows:
        """Return the table of all cycles."""
        rows = zip(self.range.tolist(), self.drift.tolist(), self.work.tolist(), strict=True)
        return ("range", "drift", "plastic work (J)", self.verdict), rows

    def __str__(self) -> str:
        return self.table()


@explained
def hinge_cycles(moment: ArrayLike, plastic: ArrayLike, *, ignore: float = 0.05) -> HingeCycles:
    """Return the load cycles of a plastic hinge with the range of its deformation in each.

    A cycle goes from one turning point of the moment to the next but one. Cycles are counted back
    from the end of the history, so that its end is included; a remaining half cycle comes first.
    The verdict compares up to three cycles, but none that begins with the history.

    Parameters
    ----------
    moment : (nt,) array_like
        Moment M that bends the hinge, N m, or force that stretches the bar, N: minus the value of
        its `ForceSensor`, which is the force on body b.
    plastic : (nt,) array_like
        Plastic deformation, rad or m: `ForceStateSensor`.
    ignore : float
        Reversals of the moment smaller than this share of its largest range do not count as cycles.

    Raises
    ------
    InputError
        If histories are empty, not finite, of different lengths, or the moment has the wrong sign.

    Examples
    --------
    >>> M = [0.0, 4000.0, -4000.0, 4000.0, -4000.0]
    >>> print(hinge_cycles(M, [0.0, 0.05, -0.05, 0.05, -0.05]).verdict)
    alternating
    """
    M, p = _histories("hinge cycles", moment, plastic)
    problems = Problems()
    problems.number("hinge cycles", "ignore", ignore, "", "0 to below 1", lambda x: 0 <= x < 1)
    problems.raise_if_any()
    ends = _large_turns(M, ignore * float(np.ptp(M)))
    ends = _plateau_ends(M, ends)
    first = (len(ends) - 1) % 2
    starts, stops = ends[first:-2:2], ends[first + 2 :: 2]
    work = np.concatenate([[0.0], np.cumsum(0.5 * (M[1:] + M[:-1]) * np.diff(p))])
    ranges = np.array([np.ptp(p[i : j + 1]) for i, j in zip(starts, stops, strict=True)])
    drift = p[stops] - p[starts]
    return HingeCycles(
        range=ranges,
        drift=drift,
        work=work[stops] - work[starts],
        largest=float(np.abs(p).max()),
        verdict=_verdict(p, ranges, drift, len(ranges) - 1 + first),
    )


def _verdict(p: Array, ranges: Array, drift: Array, like: int) -> str:
    """Return the verdict; the last `like` cycles do not begin with the history."""
    whole = float(np.ptp(p))
    if whole == 0.0:
        return "elastic"
    if not len(ranges):
        warn("hinge cycles", "the moment has no complete cycle; the run is too short for a verdict")
        return "undecided"
    if ranges[-1] <= STILL * whole:
        return "shakedown"
    closed = abs(drift[-1]) <= CLOSED * ranges[-1]
    x = (ranges if closed else np.abs(drift))[len(ranges) - min(like, LAST) :]
    if len(x) < 2:
        return "alternating" if closed else "undecided"
    if (x[1:] < (1.0 - TREND) * x[:-1]).all():
        return "settling"
    if x[-1] > UNLIKE * x[:-1].max():
        return "undecided"
    if closed:
        return "alternating"
    return "ratchet" if drift[-1] * drift[-2] > 0.0 else "undecided"


def _large_turns(x: Array, small: float) -> NDArray[np.int64]:
    """Return the indices of the turning points left after removing turns smaller than `small`."""
    values, index = turning_points(x)
    kept: list[int] = [0]
    for k in range(1, len(values)):
        last = values[kept[-1]]
        if len(kept) >= 2 and (values[k] - last) * (last - values[kept[-2]]) >= 0.0:
            kept[-1] = k  # the series continues in the same direction
        elif abs(values[k] - last) > small:
            kept.append(k)
    return index[kept]


def _plateau_ends(M: Array, ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the last instants at the turning points: without hardening it yields on a plateau."""
    same = ROUND * float(np.ptp(M))
    out = ends.copy()
    for k, (i, j) in enumerate(zip(ends[:-1], ends[1:], strict=True)):
        out[k] = i + np.flatnonzero(np.abs(M[i:j] - M[i]) <= same)[-1]
    out[-1] = len(M) - 1  # including the yielding after the last turn
    return out


@explained
def hinge_life(
    moment: ArrayLike,
    plastic: ArrayLike,
    material: StrainLife,
    *,
    length: float,
    modulus: float,
    depth: float | None = None,
    residue: Residue,
    form: Form = "swt",
) -> LocalCycles:
    """Return the strain loops of the outer fibre of a plastic hinge, with their damage.

    The strain is ``M / (E W) + p h / (2 l_p)``: the curvature of the plastic deformation p over the
    plastic length l_p, at half the depth h of the section, and the elastic strain. A bar has
    ``F / (E A) + p / l_p``. The stress of the mean stress correction is ``M / W`` or ``F / A``.

    Parameters
    ----------
    moment, plastic : (nt,) array_like
        As for `hinge_cycles`.
    material : StrainLife
    length : float
        Plastic length l_p, m: the length over which the deformation of the hinge is spread, often
        half the depth to the depth of the section. It has no default, since the life depends on it
        directly.
    modulus : float
        Elastic section modulus W, m3; with ``depth=None`` the area A, m2.
    depth : float, optional
        Depth h of the section in the plane of bending, m; None for a bar under axial force.
    residue : {"half", "repeat", "ignore"}
        As for `local_cycles`; mandatory.
    form : {"coffin-manson", "morrow", "swt"}
        Form of the mean stress correction.

    Raises
    ------
    InputError
        If histories are empty, not finite, of different lengths, or the moment has the wrong sign;
        if a number is not positive, or a word unknown.

    Warns
    -----
    JoustoWarning
        If the history is to be repeated and ends at another plastic deformation than it starts at.

    Examples
    --------
    >>> from jousto.fatigue import StrainLife
    >>> steel = StrainLife(E=206e9, sf=930e6, b=-0.095, ef=0.26, c=-0.47)
    >>> found = hinge_life([100, -100, 100], [0.02, -0.02, 0.02], steel,
    ...                    length=0.1, modulus=1.0, depth=0.1, residue="repeat")
    >>> round(2 * found.life, 3)
    1748.506
    """
    where = "hinge life"
    problems = Problems()
    for name, value, unit in (("length", length, "m"), ("modulus", modulus, "m3")):
        problems.positive(where, name, value, unit)
    if depth is not None:
        problems.positive(where, "depth", depth, "m")
    if residue not in RESIDUES:
        problems.add(where, f"residue is {residue!r}{suggest(residue, RESIDUES)}")
    if form not in FORMS:
        problems.add(where, f"form is {form!r}{suggest(form, FORMS)}")
    problems.raise_if_any()
    M, p = _histories(where, moment, plastic)
    lever = 1.0 if depth is None else 0.5 * depth
    stress = M / modulus
    strain = stress / material.E + p * lever / length
    if residue == "repeat":
        _check_closed(where, p)
        turn = int(np.argmax(np.abs(strain)))
        stress, strain = (np.concatenate([x[turn:], x[: turn + 1]]) for x in (stress, strain))
    turns, index = turning_points(strain)
    i, j, count = loops(turns, residue)
    amplitude = 0.5 * np.abs(turns[i] - turns[j])
    mean = 0.5 * (stress[index[i]] + stress[index[j]])
    return LocalCycles(
        strain=amplitude,
        stress=0.5 * np.abs(stress[index[i]] - stress[index[j]]),
        mean=mean,
        count=count,
        cycles=material.cycles(amplitude, mean=mean, form=form),
        residue=residue,
        rule="hinge",
        form=form,
        material=material.name,
    )


def _check_closed(where: str, p: Array) -> None:
    whole = float(np.ptp(p))
    if abs(p[-1] - p[0]) > OPEN * whole:
        warn(
            where,
            f"the plastic deformation goes from {p[0]:.4g} to {p[-1]:.4g}: a repetition of the "
            "history would start from there; give a whole cycle at its steady state, or "
            "residue='half'",
        )


def _histories(where: str, moment: ArrayLike, plastic: ArrayLike) -> tuple[Array, Array]:
    """Return the histories of the moment and of the plastic deformation, (nt,) each."""
    problems = Problems()
    out = []
    for name, series in (("moment", moment), ("plastic", plastic)):
        one = np.ndim(series) == 2 and np.shape(series)[1] == 1  # a sensor with one component
        x = problems.array(where, name, series, (None, 1) if one else (None,))
        out.append(x[:, 0] if one and x is not None else x)
    M, p = out
    if M is not None and p is not None:
        if len(M) != len(p):
            problems.add(where, f"{len(M)} values of moment, {len(p)} of plastic; give as many")
        elif not len(M):
            problems.add(where, "the histories are empty")
        elif _is_against(M, p):
            problems.add(
                where,
                "the plastic work of the whole history is negative, the plastic deformation goes "
                "against the moment; a ForceSensor has the force on "
                "body b, give minus its value",
            )
    problems.raise_if_any()
    assert M is not None and p is not None
    return np.asarray(M, dtype=float), np.asarray(p, dtype=float)


def _is_against(M: Array, p: Array) -> bool:
    """Return whether the plastic deformation has the wrong sign for the moment.

    With a wrong sign the work over the history is negative. It can also be negative if the back
    force moves the hinge back after the start of the history; but then the moment increases with
    the flow, ``dM dp > 0``, as in every hinge that hardens (Drucker's postulate). With a wrong sign
    it never does.
    """
    dp = np.diff(p)
    return float((M[1:] + M[:-1]) @ dp) < 0.0 and float(np.diff(M) @ dp) <= 0.0
