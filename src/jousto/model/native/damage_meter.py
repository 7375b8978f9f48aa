"""Damage meters: fatigue damage of histories of any length, counted sample by sample."""

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
    "mean stress correction (kind and parameters)": slice(5, 8),
    "resolution (Pa)": slice(8, 9),
}
"""Parameters stored as the last numbers of a saved memory."""


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
    """Return how many numbers the memory of a meter contains."""
    return int(library.real_library().JO_METER) + rule.depth


def _place(name: str) -> int:
    """Return the index of a named number in the memory of a meter."""
    return kinds("jo_meter_place")[name]


def fingerprint(rule: MeterRule) -> Array:
    """Return the parameters (9,) that determine the damage of a memory; see `MARKS`."""
    law, values = rule.correction
    mean = [kinds("jo_mean")[law], *values.values(), 0.0, 0.0][:3]
    return np.array([*rule.curve, *mean, rule.resolution])


class DamageMeter:
    """Rainflow count and Miner's sum of stress histories, sample by sample, in fixed memory.

    Cycles are closed by the four-point rule: of four turning points A B C D, the range B C counts
    if it lies within A D. Cycles and damage equal those of the count of the whole history, for any
    division into blocks. The damage of a cycle is ``1 / N(S)`` of the S-N curve, after the mean
    stress correction. Turning points without a closed cycle, the residue, are counted by the
    residue rule when the damage is read; reading does not change the count.

    A meter stores `depth` turning points. While the ranges of the residue grow, the oldest point
    can be removed without error: it is half a cycle, as in ASTM E1049. A decreasing residue with
    more points (a free vibration that decays over dozens of cycles) is closed by force from its
    small end: `forced` is the number of these cycles, `largest_forced` their largest range, and the
    damage is never below the exact one. With ``residue="ignore"`` forced cycles count as well,
    although a decay closes no cycle: use a larger depth. With a `resolution`, no two growing or
    decreasing points are in one class: ``depth >= 2 (max - min) / resolution + 4`` never forces a
    cycle. With ``residue="repeat"`` removed oldest points count as full cycles, also a conservative
    choice.

    Parameters
    ----------
    sn : SN
        S-N curve, amplitudes in Pa.
    residue : str
        "half": half cycles, as in ASTM E1049. "repeat": the history is repeated. "ignore": no
        damage.
    mean : MeanStress, optional
        Mean stress correction, such as ``Goodman(S_u=..)``; None for no correction.
    n : int
        Number of histories that are counted in parallel.
    depth : int
        Number of turning points that each meter stores; 64 need 616 bytes.
    resolution : float
        Resolution to which samples are rounded, Pa; 0 for no rounding.

    Raises
    ------
    InputError
        With all problems of the arguments.

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
            problems.add("DamageMeter", f"n is {n!r}, must be a whole number of at least 1")
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
                f"{self.forced.sum()} cycles up to {self.largest_forced.max() / 1e6:.4g} MPa of "
                f"range were closed by force; a larger depth or a resolution avoids this"
            )
        return "\n".join(lines)

    def _pointer(self, array: NDArray[Any]) -> Any:
        return self._ffi.cast("double *", array.ctypes.data)

    def _columns(self, block: ArrayLike) -> Array:
        x: Array = np.ascontiguousarray(block, dtype=np.float64)
        if x.ndim < 2:
            # a vector is several samples of one history, or one instant of several
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
        """Count further samples.

        Parameters
        ----------
        block : (nt, n) array_like
            Stress, Pa, a row per instant; (nt,) for one history, (n,) for one instant. Samples
            that are not finite are left out and counted in `dropped`.
        """
        x = self._columns(block)
        self._library.jo_meter_block(
            self.native, self._start, self._ffi.from_buffer("double[]", x), len(x), self.n
        )

    def trace(self, samples: ArrayLike) -> Array:
        """Count further samples of a single history and return its closed cycles, (k, 2) Pa.

        Each is [from, to] in the order in which they close.
        """
        if self.n != 1:
            raise InputError(
                Problem(
                    "DamageMeter.trace",
                    f"has {self.n} histories; trace works with a single history only",
                )
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
            Rule for the residue; None for the rule of the meter.
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
        """Number of counted samples, (n,)."""
        return self._counts("samples")

    @property
    def dropped(self) -> NDArray[np.int64]:
        """Number of samples that were not finite and left out, (n,)."""
        return self._counts("dropped")

    @property
    def forced(self) -> NDArray[np.int64]:
        """Number of cycles closed by force because the memory was full, (n,)."""
        return self._counts("forced")

    @property
    def shed(self) -> NDArray[np.int64]:
        """Number of half cycles removed from a growing residue by a full memory, (n,)."""
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
        """Return the turning points outside of closed cycles, Pa; the last is the newest sample.

        With `residue` "half", points removed from a full memory are missing.
        """
        first = int(self._library.JO_METER)
        count = int(self._memory[history, _place("points")])
        return np.array(self._memory[history, first : first + count])

    # -- checkpoints ------------------------------------------------------------------------

    def save(self) -> Array:
        """Return the memory of the meter, (n, size); `load` continues from it.

        The last numbers of each row are curve, mean stress correction and resolution.
        """
        return np.hstack([self._memory, np.tile(fingerprint(self.rule), (self.n, 1))])

    def load(self, memory: ArrayLike) -> None:
        """Continue from a memory returned by `save` of a meter with the same rule.

        Curve, mean stress correction, depth and resolution must be the same: the stored damage
        depends on them. The residue rule may differ.

        Raises
        ------
        InputError
            If the memory is not that of such a meter.
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
                    f"row {rows[0]} of memory was counted with another {name}, {there}; this "
                    f"meter has {here}. Load it into a meter with the saved rule, or count from "
                    f"the start",
                )
        problems.raise_if_any()
        for i, one in enumerate(found):
            if not self._library.jo_meter_valid(self.native, self._pointer(one)):
                raise InputError(Problem(where, f"row {i} of memory is not that of a meter"))
        self._memory[:] = found


def count_cycles(
    samples: ArrayLike,
) -> tuple[Array, NDArray[np.int64], Array, NDArray[np.int64]]:
    """Count a whole history by the four-point rule, with unlimited memory.

    Parameters
    ----------
    samples : (nt,) array_like
        The history, finite.

    Returns
    -------
    cycles, where : (k, 2) arrays
        Values [from, to] of the closed cycles in the order of closing, and their indices in
        `samples`.
    residue, residue_where : (m,) arrays
        Remaining turning points, and their indices.

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
