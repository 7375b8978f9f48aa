"""FatigueCheck: settings of the fatigue assessment of a body in a model file."""

from __future__ import annotations

from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Field, OptionalText, Text, field
from jousto.base.numbers import OptionalDuration, OptionalNumber, set_fields
from jousto.mechanism.sensors.damage import Correction, Curve, Residue
from jousto.mechanism.sensors.damage_rule import RESIDUES


class StressSites(Field["str | tuple[str | int, ...]", "tuple[str | int, ...]"]):
    """Field with labels of stress sites, names of node sets or nodes; None for all."""

    form = "stress sites"
    noun = "str or sequence of str or int"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the labels as a tuple."""
        return (value,) if isinstance(value, str) else tuple(value)


class FatigueCheck(Declared):
    """Fatigue assessment of a body: the arguments of `damage_field`."""

    kind = "check"
    name: OptionalText = field("Name in tables; that of the body if not given", default=None)
    body: Text = field("Name of a flexible body", kw_only=True)
    sn: Curve = field("S-N curve: a name of curves or of the library, or its keys", kw_only=True)
    residue: Residue = field(
        "Rule for cycles open at the end of the history; must be given",
        words=RESIDUES,
        default=None,
        kw_only=True,
    )
    sites: StressSites = field(
        "Sites, node sets or nodes; all if not given", default=None, kw_only=True
    )
    criterion: AnyField = field(
        "Stress that is counted; signed-von-mises if not given",
        form="criterion",
        default=None,
        kw_only=True,
    )
    plane: AnyField = field(
        "Normal of a plane, instead of a criterion", form="plane", default=None, kw_only=True
    )
    mean: Correction = field("Mean stress correction", default=None, kw_only=True)
    required: OptionalDuration = field("Required life", default=None, kw_only=True)
    allowable: OptionalNumber = field(
        "Allowable Miner's sum, 1 if not given", default=None, kw_only=True
    )
    survival: OptionalNumber = field(
        "Probability of survival of the results", default=None, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Set a missing name to that of the body."""
        set_fields(self, name=self.name or self.body)

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments of `damage_field`."""
        keys = ("mean", "required", "allowable", "survival")
        found = {"criterion": self.criterion if self.plane is None else self.plane}
        found |= {key: getattr(self, key) for key in keys}
        return {key: value for key, value in found.items() if value is not None}
