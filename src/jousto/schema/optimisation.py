"""Optimisation settings of a model file."""

from __future__ import annotations

from jousto.base.errors import Problems
from jousto.base.fields import Choice, field
from jousto.design.optimisation.rigid_options import RigidMachine


class Optimisation(RigidMachine):
    """Machine that an optimisation of the model file runs."""

    kind = "optimisation"
    machine: Choice = field(
        "Machine of the runs: with its flexible bodies, or with all bodies rigid, so that each "
        "flexible part vibrates alone under the loads of the rigid run",
        words=("flexible", "rigid"),
        default="flexible",
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report options of a rigid machine for a flexible one."""
        for key, option in RigidMachine.fields.items():
            if self.machine == "flexible" and getattr(self, key) != option.default:
                problems.add(where, f"{key} has no effect without machine: rigid", key)

    @property
    def rigid(self) -> RigidMachine | None:
        """Options of the rigid machine; None for the flexible machine."""
        if self.machine == "flexible":
            return None
        return RigidMachine(**{key: getattr(self, key) for key in RigidMachine.fields})
