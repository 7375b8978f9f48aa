"""Damage meters: fatigue damage of histories of any length, counted as they come."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.ranking import largest
from jousto.mechanism.sensors.damage_rule import MeterRule, check_residue, meter_rule
from jousto.model.native import library
from jousto.model.native.header import kinds

MARKS = {
    "S-N curve (S_D in Pa, N_D, k, slope below, limit in Pa)": slice(0, 5),
    "mean stress correction (kind and values)": slice(5, 8),
    "resolution (Pa)": slice(8, 9),
}
"""What a saved memory was counted with: its last numbers."""


def native_rule(ffi: Any, rule: MeterRule) -> Any:
    """Return the jo_meter of a rule."""
    r = ffi.new("jo_meter *")
    r.depth, r.residue, r.width = rule.depth, kinds("jo_residue")[rule.residue], rule.resolution
    r.amplitude, r.cycles, r.slope, r.below, r.cut = rule.curve
    law, values = rule.correction
    r.mean = kinds("jo_mean")[law]
    for name, value in values.items():
        setattr(r, name, value)
    r.factor = 1.0
    return r


def meter_size(rule: MeterRule) -> int:
    """Return how many numbers a meter remembers."""
    return int(library.real_library().JO_METER) + rule.depth


def _place(name: str) -> int:
    """Return where a number stands in the memory of a meter."""
    return kinds("jo_meter_place")[name]


def fingerprint(rule: MeterRule) -> Array:
    """Return the numbers (9,) that the damage of a memory depends on; see `MARKS`."""
    law, values = rule.correction
    mean = [kinds("jo_mean")[law], *values.values(), 0.0, 0.0][:3]
    return np.array([*rule.curve, *mean, rule.resolution])


class DamageMeter:
    """Rainflow count and Miner's sum of stress histories as they come, in fixed memory.

    Cycles are closed by the four-point rule: of the turning points A B C D the range B C counts if
    it lies within A D. They, and so the damage, are those of the count of the whole history at
    once, however it is cut into blocks. Damage of a cycle is ``1 / N(S)`` of the S-N curve, after
    the mean stress correction. What is not closed, the residue, counts as declared when the damage
    is read; reading does not disturb the count.

    A meter remembers `depth` turning points. While the ranges of the residue grow, the oldest point
    can leave without harm: it is half a cycle, as in ASTM E1049. A residue that shrinks and is
    longer than that (a free vibration that decays for dozens of cycles) is closed by force from its
    small end: `forced` is their number, `largest_forced` the largest of their ranges, and the
    damage is never below the exact one. With ``residue="ignore"`` forced cycles count as well,
    although a decay closes none: read it with more depth. With a `resolution` no two of the growing
    or shrinking points fall into one class: ``depth >= 2 (max - min) / resolution + 4`` never
    forces any. With ``residue="repeat"`` oldest points that left count as full cycles, also the
    careful side.

    Parameters
    ----------
    sn : SN
        S-N curve, amplitudes in Pa.
    residue : str
        "half": half cycles, as in ASTM E1049. "repeat": the history starts again.
        "ignore": not at all.
    mean : MeanStress, optional
        Mean stress correction, such as ``Goodman(S_u=..)``; None leaves amplitudes as they are.
    n : int
        Number of histories that are counted side by side.
    depth : int
        Turning points that each meter remembers; 64 are 616 bytes.
    resolution : float
        Samples are rounded to multiples of it, Pa; 0 takes them as they are.

    Raises
    ------
    InputError
        With everything that is wrong.

    Examples
    --------
    The block of ASTM E1049-85, figure 6, times 25 MPa:

    >>> import jousto as jo
    >>> meter = DamageMeter(jo.SN(S_D=100e6, N_D=1e6, k=5), residue="half")
    >>> meter.push(25e6 * np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2]))
    >>> print(f"{meter.damage()[0]:.8e}")
    2.07025146e-06
    """

    def __init__(
        self,
        sn: Any,
        *,
        residue: str,
        mean: Any = None,
        n: int = 1,
        depth: int = 64,
        resolution: float = 0.0,
    ) -> None:
        problems = Problems()
        rule = meter_rule(
            problems,
            "DamageMeter",
            sn,
            residue=residue,
            mean=mean,
            depth=depth,
            resolution=resolution,
        )
        count: Any = n
        if not isinstance(count, int | np.integer) or isinstance(count, bool) or count < 1:
            problems.add("DamageMeter", f"n is {n!r}, must be a whole number from 1 on")
        problems.raise_if_any()
        self.sn = sn
        self.mean = mean
        self.rule = rule
        self.n = int(n)
        self._library, self._ffi = library.real_library(), library.ffi()
        self.native = native_rule(self._ffi, rule)
        self._memory = np.zeros((self.n, meter_size(rule)))
        self._start = self._pointer(self._memory)
        self._scratch = np.zeros(self._library.JO_METER + 2 * rule.depth + 2)

    def __repr__(self) -> str:
        return f"<DamageMeter: {self.n} histories, residue {self.rule.residue!r}>"

    def __str__(self) -> str:
        damage = self.damage()
        worst = largest(damage)
        lines = [
            f"{self.n} {'history' if self.n == 1 else 'histories'}, residue {self.rule.residue},"
            f" mean stress {'not corrected' if self.mean is None else self.mean}",
            f"curve: {self.sn}",
            f"largest damage {damage[worst]:.6g} (history {worst}) after"
            f" {self.samples[worst]} samples, {self.cycles[worst]} closed cycles",
        ]
        if self.dropped.any():
            lines.append(f"{self.dropped.sum()} samples were not finite and left out")
        if self.forced.any():
            lines.append(
                f"{self.forced.sum()} cycles up to {self.largest_forced.max() / 1e6:.4g} MPa of"
                " range were closed by force; more depth, or a resolution, would not"
            )
        return "\n".join(lines)

    def _pointer(self, array: NDArray[Any]) -> Any:
        return self._ffi.cast("double *", array.ctypes.data)

    def _columns(self, block: ArrayLike) -> Array:
        x: Array = np.ascontiguousarray(block, dtype=np.float64)
        if x.ndim < 2:
            # of one history its samples, of several one instant
            x = x.reshape(-1, 1) if self.n == 1 else x.reshape(1, -1)
        if x.ndim != 2 or x.shape[1] != self.n:
            raise InputError(
                Problem(
                    "DamageMeter.push",
                    f"block is {np.shape(block)}, must be (nt, {self.n}): a row for every instant,"
                    " a column for every history",
                )
            )
        return x

    def push(self, block: ArrayLike) -> None:
        """Count the next samples.

        Parameters
        ----------
        block : (nt, n) array_like
            Stress, Pa, a row for each instant; (nt,) of one history, (n,) of one instant. Samples
            that are not finite are left out and counted in `dropped`.
        """
        x = self._columns(block)
        self._library.jo_meter_block(
            self.native, self._start, self._ffi.from_buffer("double[]", x), len(x), self.n
        )

    def trace(self, samples: ArrayLike) -> Array:
        """Count the next samples of a single history and return its closed cycles, (k, 2) Pa.

        Each is [from, to] in the order in which they close.
        """
        if self.n != 1:
            raise InputError(
                Problem("DamageMeter.trace", f"has {self.n} histories, follows a single one only")
            )
        x = self._columns(samples)
        cycles = np.zeros((len(x) // 2 + self.rule.depth, 2))
        closed = self._library.jo_meter_trace(
            self.native,
            self._pointer(self._memory),
            self._pointer(x),
            len(x),
            self._pointer(cycles),
        )
        return cycles[:closed]

    def damage(self, residue: str | None = None) -> Array:
        """Return Miner's sum of each history, (n,), 1 is failure.

        Parameters
        ----------
        residue : str, optional
            Another rule for the residue than the meter's own.
        """
        rule = self.rule.residue if residue is None else residue
        problems = Problems()
        check_residue(problems, "DamageMeter.damage", rule)
        problems.raise_if_any()
        out = np.zeros(self.n)
        self._library.jo_meter_damages(
            self.native,
            self._pointer(self._memory),
            self.n,
            kinds("jo_residue")[rule],
            self._pointer(self._scratch),
            self._pointer(out),
        )
        return out

    def _counts(self, name: str) -> NDArray[np.int64]:
        return self._memory[:, _place(name)].astype(np.int64)

    @property
    def cycles(self) -> NDArray[np.int64]:
        """Closed cycles of each history, (n,)."""
        return self._counts("closed")

    @property
    def samples(self) -> NDArray[np.int64]:
        """Samples counted, (n,)."""
        return self._counts("samples")

    @property
    def dropped(self) -> NDArray[np.int64]:
        """Samples that were not finite and left out, (n,)."""
        return self._counts("dropped")

    @property
    def forced(self) -> NDArray[np.int64]:
        """Cycles that were closed by force because the memory was full, (n,)."""
        return self._counts("forced")

    @property
    def shed(self) -> NDArray[np.int64]:
        """Half cycles that left a growing residue because the memory was full, (n,)."""
        return self._counts("shed")

    @property
    def largest_forced(self) -> Array:
        """Largest range that was closed by force, (n,) Pa."""
        return self._memory[:, _place("largest forced")].copy()

    @property
    def extremes(self) -> Array:
        """Smallest and largest sample, (n, 2) Pa."""
        return self._memory[:, [_place("smallest"), _place("largest")]].copy()

    def residue(self, history: int = 0) -> Array:
        """Return the turning points that no cycle has taken yet, Pa; the last is the newest sample.

        Of `residue` "half", points that left a full memory are missing.
        """
        first = int(self._library.JO_METER)
        count = int(self._memory[history, _place("points")])
        return np.array(self._memory[history, first : first + count])

    # -- checkpoints ------------------------------------------------------------------------

    def save(self) -> Array:
        """Return all that the meter remembers, (n, size); `load` continues from it.

        The last numbers of each row are curve, mean stress correction and resolution.
        """
        return np.hstack([self._memory, np.tile(fingerprint(self.rule), (self.n, 1))])

    def load(self, memory: ArrayLike) -> None:
        """Go on from what `save` returned, of a meter that counts in the same way.

        Curve, mean stress correction, depth and resolution must be the same: the damage so far
        holds for them alone. The residue rule may be another.

        Raises
        ------
        InputError
            If it is none of such a meter.
        """
        found = np.ascontiguousarray(memory, dtype=np.float64)
        where = "DamageMeter.load"
        own = fingerprint(self.rule)
        shape = (self.n, self._memory.shape[1] + len(own))
        if found.shape != shape:
            raise InputError(
                Problem(
                    where,
                    f"memory is {found.shape}, this meter's is {shape}; give the same n and depth",
                )
            )
        found, marks = np.split(found, [self._memory.shape[1]], axis=1)
        found = np.ascontiguousarray(found)
        problems = Problems()
        other = ~np.isclose(marks, own, rtol=1e-12, atol=0.0, equal_nan=True)
        for name, columns in MARKS.items():
            rows = np.flatnonzero(other[:, columns].any(axis=1))
            if len(rows):
                here, there = (
                    ", ".join(f"{x:.6g}" for x in values[columns])
                    for values in (own, marks[rows[0]])
                )
                problems.add(
                    where,
                    f"row {rows[0]} of memory was counted with another {name}, {there}; this"
                    f" meter's is {here}. Load it into a meter like the one that was saved, or"
                    " count anew",
                )
        problems.raise_if_any()
        for i, one in enumerate(found):
            if not self._library.jo_meter_valid(self.native, self._pointer(one)):
                raise InputError(Problem(where, f"row {i} of memory is not that of a meter"))
        self._memory[:] = found


def count_cycles(
    samples: ArrayLike,
) -> tuple[Array, NDArray[np.int64], Array, NDArray[np.int64]]:
    """Count a whole history at once by the four-point rule, without limit of memory.

    Parameters
    ----------
    samples : (nt,) array_like
        The history, finite.

    Returns
    -------
    cycles, where : (k, 2) arrays
        Values [from, to] of the closed cycles in the order in which they close, and their places in
        `samples`.
    residue, residue_where : (m,) arrays
        The turning points that are left, and their places.

    Examples
    --------
    >>> cycles, where, residue, _ = count_cycles([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> cycles.tolist(), where.tolist()
    ([[-1.0, 3.0]], [[4, 5]])
    >>> residue.tolist()
    [-2.0, 1.0, -3.0, 5.0, -4.0, 4.0, -2.0]
    """
    x = np.ascontiguousarray(samples, dtype=np.float64)
    problems = Problems()
    if x.ndim != 1:
        problems.add("count_cycles", f"samples are {x.shape}, must be one history (nt,)")
    elif not np.isfinite(x).all():
        bad = int(np.argmin(np.isfinite(x)))
        problems.add("count_cycles", f"sample {bad} is {x[bad]}, must be finite; leave it out")
    problems.raise_if_any()
    engine, ffi = library.real_library(), library.ffi()
    count = len(x)
    cycles, where = np.empty((count // 2 + 1, 2)), np.empty((count // 2 + 1, 2), np.int64)
    residue, residue_where = np.empty(count + 1), np.empty(count + 1, np.int64)
    length = ffi.new("long long *")
    closed = engine.jo_rainflow(
        ffi.from_buffer("double[]", x),
        count,
        ffi.from_buffer("double[]", cycles),
        ffi.from_buffer("long long[]", where),
        ffi.from_buffer("double[]", residue),
        ffi.from_buffer("long long[]", residue_where),
        length,
    )
    left = int(length[0])
    return cycles[:closed], where[:closed], residue[:left], residue_where[:left]
