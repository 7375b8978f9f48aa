"""Strain life: local stress and strain at a notch from linear elastic stress, and damage.

The stress of a modal body is linear elastic. Above the cyclic yield stress the local stress is
lower and the strain higher, by Neuber's rule ``s e = S^2/E`` or Glinka's equal strain energy.
Hysteresis branches are the doubled cyclic curve (Masing); after a loop is closed, the branch
continues on the interrupted curve (material memory), so that every loop has its own mean stress.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.base.ranking import ranking
from jousto.fatigue.cycles.rainflow import count_turning, turning_points
from jousto.materials.strength.strain_life import FORMS, Form, StrainLife
from jousto.mechanism.sensors.damage_rule import RESIDUES

Rule = Literal["neuber", "glinka", "elastic"]
RULES = ("neuber", "glinka", "elastic")
Residue = Literal["half", "repeat", "ignore"]


@explained
def neuber(stress: ArrayLike, material: StrainLife) -> tuple[Array, Array]:
    """Return local stress (Pa) and strain (m/m) of a linear elastic stress by Neuber's rule.

    ``s e = S^2 / E`` on the cyclic curve; amplitudes or, from a virgin state, values.

    Parameters
    ----------
    stress : array_like
        Linear elastic stress at the notch S (nominal stress times K_t), Pa.
    material : StrainLife

    Examples
    --------
    >>> import jousto as jo
    >>> s, e = neuber(600e6, jo.fatigue.strain_life("sae-1045"))
    >>> bool(abs(s * e - 600e6**2 / 202e9) < 1e-6 * s * e)
    True
    """
    return _notch(stress, material, 1.0)


@explained
def glinka(stress: ArrayLike, material: StrainLife) -> tuple[Array, Array]:
    """Return local stress (Pa) and strain (m/m) by Glinka's equivalent strain energy density.

    ``s^2/2E + s/(n'+1) (s/K')^(1/n') = S^2/2E`` (Molski and Glinka, *Mater. Sci. Eng.* 50 (1981)
    93-100).

    Parameters
    ----------
    stress : array_like
        Linear elastic stress at the notch, Pa.
    material : StrainLife
    """
    return _notch(stress, material, 2.0 / (1.0 + material.hardening[1]))


def _notch(stress: ArrayLike, material: StrainLife, share: float) -> tuple[Array, Array]:
    """Return stress and strain from ``s^2/E + share s (s/K')^(1/n') = S^2/E``, by Newton."""
    S = np.asarray(stress, dtype=np.float64)
    if not np.all(np.isfinite(S)):
        raise InputError(Problem("notch", "the elastic stress has values that are not finite"))
    K, n = material.hardening
    E, size = material.E, np.abs(S)
    energy = size * size / E
    # start at the upper bound by each term alone; the left side is convex
    s = np.minimum(size, (energy / share * K ** (1.0 / n)) ** (n / (1.0 + n)))
    for _ in range(60):
        plastic = share * s * (s / K) ** (1.0 / n)
        slope = 2.0 * s / E + (1.0 + 1.0 / n) * plastic / np.where(s > 0.0, s, 1.0)
        step = (s * s / E + plastic - energy) / np.where(slope > 0.0, slope, 1.0)
        s = np.maximum(s - step, 0.0)
        if np.all(np.abs(step) <= 1e-14 * s):
            break
    s = np.sign(S) * s
    return np.asarray(s), material.strain(s)


@described
@dataclass(frozen=True, eq=False)
class LocalPath:
    """Local stress and strain at the turning points of an elastic history.

    Attributes
    ----------
    index : (n,) int array
        Indices of the turning points in the history.
    elastic, stress, strain : (n,) arrays
        Linear elastic and local stress in Pa, local strain in m/m.
    """

    index: NDArray[np.int64]
    elastic: Array
    stress: Array
    strain: Array


@explained
def local_path(series: ArrayLike, material: StrainLife, *, rule: Rule = "neuber") -> LocalPath:
    """Return local stress and strain at a notch over a history that starts in the virgin state.

    Parameters
    ----------
    series : (nt,) array_like
        Linear elastic stress, Pa.
    material : StrainLife
    rule : {"neuber", "glinka", "elastic"}
        Notch rule; ``elastic`` keeps the linear elastic stress.

    Raises
    ------
    InputError
        For an empty history, values that are not finite, or an unknown rule.
    """
    x = _checked(series, rule)
    S, index = turning_points(x)
    start = np.full(
        len(S), -1, dtype=np.intp
    )  # turning point at the start of the branch; -1 for the virgin curve
    stack: list[int] = []
    largest = 0.0
    for k, value in enumerate(S):
        # close the loops that are smaller than this branch
        while len(stack) >= 2 and abs(value - S[stack[-1]]) >= abs(S[stack[-1]] - S[stack[-2]]):
            del stack[-2:]
        # on the virgin curve: clear the memory. Round-off of equal ranges may close all loops
        # slightly below the largest value
        if abs(value) >= largest or not stack:
            stack, largest = [k], max(largest, abs(float(value)))
        else:
            start[k] = stack[-1]
            stack.append(k)
    first = start < 0
    origin = np.where(first, 0.0, S[start])
    half = np.where(first, S, 0.5 * (S - origin))
    s, e = _rule(half, material, rule)
    stress, strain = np.where(first, s, 2.0 * s), np.where(first, e, 2.0 * e)
    for k in np.flatnonzero(~first).tolist():
        stress[k] += stress[start[k]]
        strain[k] += strain[start[k]]
    return LocalPath(index, S, stress, strain)


def _rule(S: Array, material: StrainLife, rule: Rule) -> tuple[Array, Array]:
    if rule == "neuber":
        return neuber(S, material)
    if rule == "glinka":
        return glinka(S, material)
    return S, S / material.E


def _checked(series: ArrayLike, rule: str) -> Array:
    problems = Problems()
    x = problems.array("strain life", "history", series, (None,))
    if x is not None and not len(x):
        problems.add("strain life", "the history is empty")
    if rule not in RULES:
        problems.add("strain life", f"notch rule is {rule!r}{suggest(rule, RULES)}")
    problems.raise_if_any()
    assert x is not None
    return x


@described
@dataclass(frozen=True, eq=False)
class LocalCycles(Tabular):
    """Hysteresis loops at a notch with their damage.

    Attributes
    ----------
    strain : (n,) array
        Strain amplitude, m/m.
    stress : (n,) array
        Stress amplitude, Pa.
    mean : (n,) array
        Mean stress, Pa.
    count : (n,) array
        1 for a closed loop, 0.5 for a half cycle of the residue.
    cycles : (n,) array
        Life of each loop at constant amplitude, cycles.
    residue, rule, form : str
        Residue rule, notch rule and form of the mean stress correction.
    material : str
    """

    strain: Array
    stress: Array
    mean: Array
    count: Array
    cycles: Array
    residue: str
    rule: str
    form: str
    material: str

    @property
    def damage(self) -> float:
        """Miner's sum of one repetition of the history."""
        return float(np.sum(self.count / self.cycles)) if len(self.count) else 0.0

    @property
    def life(self) -> float:
        """Number of repetitions of the history to crack initiation; inf without damage."""
        with np.errstate(divide="ignore"):
            return float(np.float64(1.0) / self.damage)

    def table(self, rows: int = 10) -> str:
        """Return a table of the loops with the largest damage."""
        share = self.count / self.cycles
        order = ranking(share)[:rows]
        lines = [
            f"strain life of {self.material or 'a material'}: {self.rule}, {self.form}, "
            f"residue '{self.residue}'",
            f"damage {self.damage:.4g} per pass, life {self.life:.4g} passes",
            f"{'strain':>12} {'stress':>9} {'mean':>9} {'count':>6} {'cycles':>11} {'share':>7}",
            f"{'um/m':>12} {'MPa':>9} {'MPa':>9} {'':>6} {'':>11} {'%':>7}",
        ]
        whole = self.damage or 1.0
        lines += [
            f"{1e6 * self.strain[i]:12.1f} {1e-6 * self.stress[i]:9.2f} {1e-6 * self.mean[i]:9.2f} "
            f"{self.count[i]:6.1f} {self.cycles[i]:11.4g} {100 * share[i] / whole:7.2f}"
            for i in order
        ]
        return "\n".join(lines)

    def _csv(self) -> Rows:
        """Return the table of all loops."""
        head = ("strain amplitude", "stress amplitude (Pa)", "mean (Pa)", "count", "cycles")
        columns = (self.strain, self.stress, self.mean, self.count, self.cycles)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return (*head, f"residue: {self.residue}"), rows

    def __str__(self) -> str:
        return self.table()


@explained
def local_cycles(
    series: ArrayLike,
    material: StrainLife,
    *,
    residue: Residue,
    rule: Rule = "neuber",
    form: Form = "swt",
) -> LocalCycles:
    """Return the hysteresis loops at a notch over a stress history, with their damage.

    Parameters
    ----------
    series : (nt,) array_like
        Linear elastic stress at the notch, Pa, with its sign (a component, a principal or the
        signed von Mises stress).
    material : StrainLife
    residue : {"half", "repeat", "ignore"}
        Rule for loops that do not close within the history: half loops (ASTM E1049), the loops
        closed by further repetitions of the history (without the first one, which starts in the
        virgin state), or none. Mandatory, since it may change a life by a factor of ten.
    rule : {"neuber", "glinka", "elastic"}
        Notch rule.
    form : {"coffin-manson", "morrow", "swt"}
        Form of the mean stress correction.

    Raises
    ------
    InputError
        For an empty history, values that are not finite, or an unknown rule, residue or form.

    Examples
    --------
    >>> import jousto as jo
    >>> S = [500e6, -500e6, 500e6]
    >>> loops = local_cycles(S, jo.fatigue.strain_life("sae-1045"), residue="repeat")
    >>> print(loops.count, (loops.mean / 1e6).round(6))
    [1.] [0.]
    """
    problems = Problems()
    if residue not in RESIDUES:
        problems.add("strain life", f"residue is {residue!r}{suggest(residue, RESIDUES)}")
    if form not in FORMS:
        problems.add("strain life", f"form is {form!r}{suggest(form, FORMS)}")
    problems.raise_if_any()
    x = _checked(series, rule)
    peak = float(np.abs(x).max())
    if 1e-2 < peak < min(5e3, 1e-4 * material.sf):
        warn(
            "strain life",
            f"the largest stress is {peak:.4g} Pa where the material has sf ="
            f" {material.sf / 1e6:.4g} MPa; are the stresses in MPa? SI needs Pa",
        )
    if residue == "repeat":
        # start and end at the largest value, so that every loop closes
        turn = int(np.argmax(np.abs(x)))
        x = np.concatenate([x[turn:], x[: turn + 1]])
    path = local_path(x, material, rule=rule)
    i, j, count = loops(path.elastic, residue)
    strain = 0.5 * np.abs(path.strain[i] - path.strain[j])
    mean = 0.5 * (path.stress[i] + path.stress[j])
    return LocalCycles(
        strain=strain,
        stress=0.5 * np.abs(path.stress[i] - path.stress[j]),
        mean=mean,
        count=count,
        cycles=material.cycles(strain, mean=mean, form=form),
        residue=residue,
        rule=rule,
        form=form,
        material=material.name,
    )


@described
@dataclass(frozen=True, eq=False)
class StrainDamage(Tabular):
    """Strain life at several sites of a body.

    Attributes
    ----------
    labels : tuple of str
    loops : tuple of LocalCycles
        Hysteresis loops of each site.
    criterion : str
        Name of the linear elastic stress.
    """

    labels: tuple[str, ...]
    loops: tuple[LocalCycles, ...]
    criterion: str

    @property
    def damage(self) -> Array:
        """Miner's sums (ns,) of one repetition of the history."""
        return np.array([loops.damage for loops in self.loops])

    @property
    def life(self) -> Array:
        """Number of repetitions of the history to crack initiation, (ns,)."""
        return np.array([loops.life for loops in self.loops])

    def table(self, rows: int = 10) -> str:
        """Return a table of the sites with the largest damage."""
        first = self.loops[0]
        width = max(12, *(len(label) for label in self.labels))
        lines = [
            f"strain life of {first.material or 'a material'} from {self.criterion}: {first.rule}, "
            f"{first.form}, residue '{first.residue}'",
            f"{'site':>{width}} {'damage':>11} {'life':>11} {'strain':>10} {'mean':>9}",
            f"{'':>{width}} {'':>11} {'passes':>11} {'um/m':>10} {'MPa':>9}",
        ]
        for i in ranking(self.damage, self.labels)[:rows]:
            loops = self.loops[i]
            top = int(np.argmax(loops.strain)) if len(loops.strain) else -1
            strain, mean = (loops.strain[top], loops.mean[top]) if top >= 0 else (0.0, 0.0)
            lines.append(
                f"{self.labels[i]:>{width}} {loops.damage:11.4g} {loops.life:11.4g} "
                f"{1e6 * strain:10.1f} {1e-6 * mean:9.2f}"
            )
        return "\n".join(lines)

    def _csv(self) -> Rows:
        """Return the table of damage and life of all sites."""
        rows = zip(self.labels, self.damage.tolist(), self.life.tolist(), strict=True)
        residue = f"residue: {self.loops[0].residue}"
        return ("site", "damage", "life (passes)", residue), rows

    def __str__(self) -> str:
        return self.table()


@explained
def strain_damage(
    field: Any,
    material: StrainLife,
    *,
    residue: Residue,
    criterion: str = "signed-von-mises",
    rule: Rule = "neuber",
    form: Form = "swt",
    sites: Sequence[str] | str | None = None,
) -> StrainDamage:
    """Return the hysteresis loops and the damage at sites of a stress field.

    Parameters
    ----------
    field : StressField
        From `stress_field` or `field_from`: linear elastic stress.
    material : StrainLife
    residue : {"half", "repeat", "ignore"}
        As for `local_cycles`; mandatory.
    criterion : str
        Stress with a sign: "signed-von-mises", "signed-principal" or a component.
    rule, form : str
        As for `local_cycles`.
    sites : sequence of str, optional
        Labels of the sites; None takes all, which is slow: find the hot spots first.

    Raises
    ------
    InputError
        For unknown sites or options, or a criterion without sign.
    """
    if criterion in ("von-mises", "max-shear"):
        raise InputError(
            Problem(
                "strain life",
                f"criterion '{criterion}' has no sign and would halve the loops; take "
                "'signed-von-mises', 'signed-principal' or a component",
            )
        )
    few = field if sites is None else field.only(sites)
    values = np.asarray(few.values(criterion))
    loops = tuple(
        local_cycles(column, material, residue=residue, rule=rule, form=form) for column in values.T
    )
    return StrainDamage(tuple(few.labels), loops, criterion)


def loops(S: Array, residue: str) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Return first (n,) and last (n,) turning point and number (n,) of each cycle."""
    found, rest = count_turning(S)
    count = np.ones(len(found))
    ends = np.stack([rest[:-1], rest[1:]], axis=1)[S[rest[:-1]] != S[rest[1:]]]
    if residue == "half":
        found, count = np.concatenate([found, ends]), np.append(count, np.full(len(ends), 0.5))
    elif residue == "repeat" and len(ends) >= 2:
        # the largest loop remains between the two equal ends
        found, count = np.concatenate([found, rest[None, :2]]), np.append(count, 1.0)
    return found[:, 0], found[:, 1], count
