"""What a model file asks of the fatigue of a body."""

from __future__ import annotations

from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Field, OptionalText, Text, field
from jousto.base.numbers import OptionalDuration, OptionalNumber, set_fields
from jousto.mechanism.sensors.damage import Correction, Curve, Residue
from jousto.mechanism.sensors.damage_rule import RESIDUES


class StressSites(Field["str | tuple[str | int, ...]", "tuple[str | int, ...]"]):
    """Places where stress is known; None for all."""

    form = "stress sites"
    noun = "str or sequence of str or int"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        return (value,) if isinstance(value, str) else tuple(value)


class FatigueCheck(Declared):
    """A body whose life is to be found: the arguments of `damage_field`."""

    kind = "check"
    name: OptionalText = field("For tables; that of the body if not given", default=None)
    body: Text = field("Name of a flexible body", kw_only=True)
    sn: Curve = field("A curve: a name of curves or of the library, or its keys", kw_only=True)
    residue: Residue = field(
        "What counts of cycles that the history leaves open; must be given",
        words=RESIDUES,
        default=None,
        kw_only=True,
    )
    sites: StressSites = field(
        "Sites, node sets or nodes; all if not given", default=None, kw_only=True
    )
    criterion: AnyField = field(
        "signed-von-mises if not given", form="criterion", default=None, kw_only=True
    )
    plane: AnyField = field(
        "Normal of a plane, instead of a criterion", form="plane", default=None, kw_only=True
    )
    mean: Correction = field("Mean stress correction", default=None, kw_only=True)
    required: OptionalDuration = field("Life required", default=None, kw_only=True)
    allowable: OptionalNumber = field(
        "Miner's sum allowed, 1 if not given", default=None, kw_only=True
    )
    survival: OptionalNumber = field(
        "Probability of survival of the results", default=None, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Take the name of the body where none is given."""
        set_fields(self, name=self.name or self.body)

    @property
    def options(self) -> dict[str, Any]:
        """Further arguments of `damage_field`."""
        keys = ("mean", "required", "allowable", "survival")
        found = {"criterion": self.criterion if self.plane is None else self.plane}
        found |= {key: getattr(self, key) for key in keys}
        return {key: value for key, value in found.items() if value is not None}
