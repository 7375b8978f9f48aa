"""Options of an optimisation with rigid bodies outside."""

from __future__ import annotations

from jousto.base.declare import Declared
from jousto.base.fields import Choice, Flag, field
from jousto.base.numbers import Positive, Whole


class RigidMachine(Declared, by_value=True):
    """Loads of the parts from a machine whose bodies are all rigid (Altarriba 2010, annex 1).

    The outer loop runs the rigid machine; each flexible part then vibrates alone under its loads.

    Examples
    --------
    >>> RigidMachine(held="force", beyond=True).held
    'force'
    """

    kind = "rigid machine"

    held: Choice = field(
        'How a part is held while it vibrates: "motion", where the joints that carry the part '
        'follow the rigid run, or "force", where the part is free under all loads of the rigid run',
        words=("motion", "force"),
        default="motion",
        kw_only=True,
    )
    beyond: Flag = field(
        "Whether the vibration of a part carries the rigid bodies beyond it",
        default=False,
        kw_only=True,
    )
    load_tolerance: Positive = field(
        "Relative change of the interface loads that ends the outer loop",
        unit="1",
        default=1e-3,
        kw_only=True,
    )
    cycles: Whole = field("Largest number of outer cycles", least=1, default=20, kw_only=True)
