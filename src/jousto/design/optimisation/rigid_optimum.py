"""Result of an optimisation with rigid bodies outside, beside the peaks of the flexible machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from jousto.base.errors import count
from jousto.base.object_repr import described
from jousto.design.optimisation.optimum import ACTIVE, Optimum

CARRIED = 0.1
"""Moving mass of a part over the mass that carries it, above which both ways of holding count;
stiffness of forces on a part over its own, above which it is printed."""


@described
@dataclass(frozen=True, eq=False)
class Peak:
    """Largest value of one limit by the decoupled problem and in the flexible machine.

    Attributes
    ----------
    limit : str
        Limited quantity, with the load case.
    maximum : float
        The limit in its unit; 1 where a limit has no single unit.
    unit : str
    own : float
        Largest value / limit of the part alone.
    true : float
        Largest value / limit in the flexible machine.
    other : float or None
        Largest value / limit of the part alone, held the other way; None if not computed.
    """

    limit: str
    maximum: float
    unit: str
    own: float
    true: float
    other: float | None = None

    @property
    def excess(self) -> float:
        """Relative difference of the true peak from that of the decoupled problem."""
        return self.true / self.own - 1.0 if self.own > 0.0 else float("inf")

    def value(self, ratio: float) -> str:
        """Return a value in its unit from value / limit."""
        return f"{ratio * self.maximum:.10g} {self.unit}".rstrip()

    def __str__(self) -> str:
        other = "" if self.other is None else f", held the other way {self.value(self.other)}"
        return (
            f"{self.limit}: limit {self.value(1.0)}\n"
            f"    part alone {self.value(self.own)}{other}\n"
            f"    flexible machine {self.value(self.true)} ({100 * self.excess:+.2f} %)"
        )


@described
@dataclass(frozen=True)
class OuterCycle:
    """One outer cycle: a rigid run, then an optimisation under its loads.

    Attributes
    ----------
    values : dict of float
        Design of the rigid run.
    cost : float
    loads : float
        Relative change of the interface loads since the last rigid run; NaN at the first one.
    inner : int
        Inner cycles under these loads; 0 if the loads did not change.
    step : float
        Largest step of the inner cycles, as a share of the span of a parameter.
    """

    values: Mapping[str, float]
    cost: float
    loads: float
    inner: int
    step: float


@described
@dataclass(frozen=True, eq=False)
class RigidOptimum(Optimum):
    """Optimum of the decoupled problem, with its peaks in the flexible machine.

    `ratio` and `kept` are those of the flexible machine, `kkt`, `active` and `history` those of the
    decoupled problem; `runs` are the runs of the parts alone.

    Attributes
    ----------
    own_ratio : float
        Largest value / limit by the decoupled problem.
    peaks : tuple of Peak
        Peaks of each limit.
    outer : tuple of OuterCycle
    rigid_runs, flexible_runs : int
        Runs of the rigid machine, and of the flexible one.
    carried : dict of float
        ``m / (M + m0)`` of each part: its moving mass over the mass that carries it. Above 0.1 the
        peaks of both ways of holding the part are given.
    springs : dict of float
        Stiffness of springs and other forces on each part over its own stiffness: the part alone
        vibrates without it.
    held : str
        "motion" or "force".
    beyond : bool
        Whether each part carries the rigid bodies beyond it.
    """

    own_ratio: float = float("nan")
    peaks: tuple[Peak, ...] = ()
    outer: tuple[OuterCycle, ...] = ()
    rigid_runs: int = 0
    flexible_runs: int = 0
    carried: Mapping[str, float] = field(default_factory=dict)
    springs: Mapping[str, float] = field(default_factory=dict)
    held: str = "motion"
    beyond: bool = False

    @property
    def excess(self) -> float:
        """Relative excess of the largest true ratio above that of the decoupled problem."""
        return self.ratio / self.own_ratio - 1.0 if self.own_ratio > 0.0 else float("inf")

    @property
    def safe(self) -> bool:
        """Whether the flexible machine keeps all limits at this design."""
        return self.ratio <= 1.0 + ACTIVE

    @property
    def verdict(self) -> str:
        """Sentence that compares the decoupled problem with the flexible machine."""
        if self.safe:
            return (
                f"the flexible machine keeps all limits: its largest value / limit is "
                f"{self.ratio:.6f}, that of the parts alone {self.own_ratio:.6f}"
            )
        worst = max(self.peaks, key=lambda one: one.true, default=None)
        what = "" if worst is None else f" ({worst.limit})"
        return (
            f"UNSAFE: the flexible machine exceeds a limit by {100 * (self.ratio - 1):.2f} %{what};"
            " use machine='flexible' from here"
        )

    def _facts(self) -> str:
        return f"{super()._facts()}; {self.verdict}"

    def __str__(self) -> str:
        lines = [super().__str__(), "", f"  {self.verdict}"]
        lines += [f"  {peak}" for peak in self.peaks]
        inner = sum(one.inner for one in self.outer)
        lines.append(
            f"  {count(len(self.outer), 'outer cycle')}, {count(inner, 'inner cycle')}: "
            f"{count(self.rigid_runs, 'rigid run')}, {count(self.runs, 'component run')}, "
            f"{count(self.flexible_runs, 'flexible run')}"
        )
        for name, ratio in self.carried.items():
            if ratio > CARRIED:
                lines.append(
                    f"  part {name}: its moving mass is {ratio:.3g} of the mass that carries it, "
                    "above 0.1: look at the peaks of both ways of holding it"
                )
        for name, ratio in self.springs.items():
            if ratio > CARRIED:
                lines.append(
                    f"  part {name}: springs and other forces on it have {ratio:.3g} of its "
                    "stiffness, above 0.1: it vibrates alone without them, which only load it"
                )
        return "\n".join(lines)
