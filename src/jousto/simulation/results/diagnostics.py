"""Diagnostics of a run: energy balance, constraint residuals, number of steps and iterations."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import count
from jousto.base.object_repr import described

ROUND_OFF = 1e-12  # round-off of the balance over the largest energy
GOOD, FAIR = 1e-3, 0.05  # error of the balance over its scale; above FAIR a run is warned of
STEADY = 1e-3  # minimum of the scale over the largest kinetic energy


@described
@dataclass(frozen=True, eq=False)
class Energy:
    """Energy balance of a run: energies, losses and work, each (nt,) in J.

    Attributes
    ----------
    kinetic, strain, potential, springs : array
        Kinetic energy, strain energy of modes and beams, potential energy of gravity, energy stored
        in springs, contacts and bristles.
    dissipated, friction, work : array
        Energy lost to damping and to friction, work of forces and drives, since the start.
    contacts : array
        Part of `springs` that contacts store, in their normal forces and bristles.
    restitution, rubbed : array
        Parts of `dissipated` and of `friction` that contacts have lost: by their normal forces, and
        by their friction. A contact that is switched off loses what it stores.
    """

    kinetic: Array
    strain: Array
    potential: Array
    springs: Array
    dissipated: Array
    friction: Array
    work: Array
    contacts: Array = field(default_factory=lambda: np.zeros(0))
    restitution: Array = field(default_factory=lambda: np.zeros(0))
    rubbed: Array = field(default_factory=lambda: np.zeros(0))

    def _facts(self) -> str:
        return f"{count(len(self.work), 'instant')}, {self.verdict.removeprefix('energy ')}"

    @property
    def total(self) -> Array:
        """Sum (nt,) of kinetic, strain, potential and spring energy, J."""
        return self.kinetic + self.strain + self.potential + self.springs

    @property
    def error(self) -> Array:
        """Error (nt,) of the balance, J: total + dissipated + friction - work, minus its start."""
        balance = self.total + self.dissipated + self.friction - self.work
        return np.asarray(balance - balance[:1])

    @property
    def exchanged(self) -> float:
        """Largest energy exchanged in the run, J: the largest variation of a term."""
        return max(float(np.ptp(term)) if len(term) else 0.0 for term in self._terms)

    @property
    def scale(self) -> float:
        """Scale of the error, J: the larger of `exchanged` and 0.1 % of the kinetic energy.

        The second bound is for a machine that turns steadily: it exchanges less energy than it
        loses by rounding and by the solver's tolerance.
        """
        return max(self.exchanged, STEADY * float(np.max(self.kinetic, initial=0.0)))

    @property
    def relative_error(self) -> float:
        """Largest `error` over `scale`; 0 if the error is round-off.

        Round-off is 1e-12 of the largest term of the balance.
        """
        missed = float(np.abs(self.error).max(initial=0.0))
        largest = max(float(np.abs(term).max(initial=0.0)) for term in self._terms)
        if missed <= ROUND_OFF * largest:
            return 0.0
        return missed / self.scale if self.scale > 0.0 else np.inf

    @property
    def verdict(self) -> str:
        """Whether the balance closes: good below 0.1 % of the scale, fair below 5 %, else poor.

        Examples
        --------
        >>> still, falling = np.zeros(3), np.array([2.0, 1.0, 0.0])
        >>> kinetic = np.array([0.0, 1.0, 2.0 + 4e-7])
        >>> Energy(kinetic, still, falling, still, still, still, still).verdict
        'energy balance closes to 2e-07 of the largest energy exchanged: good'
        """
        if not all(np.isfinite(term).all() for term in self._terms):
            return "energy balance not known: this run did not record work and losses"
        share = self.relative_error
        if share == 0.0:
            return "energy balance closes to round-off: good"
        to = f"to {share:.1g} of the largest energy exchanged"
        if self.scale > self.exchanged:
            to = f"to {STEADY * share:.1g} of the largest kinetic energy"
        if share <= GOOD:
            return f"energy balance closes {to}: good"
        if share <= FAIR:
            return f"energy balance closes {to}: fair, a smaller step is more accurate"
        return f"energy balance closes only {to}: poor, take a smaller step"

    @property
    def _terms(self) -> tuple[Array, ...]:
        stored = (self.kinetic, self.strain, self.potential, self.springs)
        return (*stored, self.dissipated, self.friction, self.work)


@described
@dataclass(frozen=True, eq=False)
class Residuals:
    """Largest constraint residuals, each (nt,): ``|C|`` and ``|Cq v|``."""

    position: Array
    velocity: Array

    def _facts(self) -> str:
        largest = [float(x.max(initial=0.0)) for x in (self.position, self.velocity)]
        return (
            f"{count(len(self.position), 'instant')}, position up to {largest[0]:.2g}, "
            f"velocity up to {largest[1]:.2g}"
        )


@described
@dataclass(frozen=True, eq=False)
class Work:
    """Counts of the steps and iterations of a run, each (nt,).

    Attributes
    ----------
    steps, rejected, evaluations, iterations : array
        Steps taken, steps rejected and repeated with a shorter length, evaluations of the
        accelerations and iterations of Newton's method, all since the start.
    step : array
        Length of the last step, s.
    """

    steps: Array
    rejected: Array
    evaluations: Array
    iterations: Array
    step: Array

    def _facts(self) -> str:
        names = ("steps", "rejected", "evaluations", "iterations")
        return ", ".join(f"{getattr(self, name)[-1:].sum():.0f} {name}" for name in names)
