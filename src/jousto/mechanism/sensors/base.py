"""What all sensors share."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from jousto.base.declare import Declared
from jousto.base.fields import Name, field


class Sensor(Declared, section="sensors"):
    """What the engine records while it steps.

    Attributes
    ----------
    unit : str
        Unit of the components; two with a comma between are those of their halves.
    components : tuple of str
        Names of the components.
    frame : str
        Name of the axes that they are in.
    description : str
        One line for results and plots.
    """

    kind = "sensor"
    flexible: ClassVar[bool] = False
    """Whether it measures what rigid bodies do not have: modes, stress, strain."""
    name: Name = field("Unique among the sensors")

    if TYPE_CHECKING:

        @property
        def unit(self) -> str: ...  # noqa: D102
        @property
        def components(self) -> tuple[str, ...]: ...  # noqa: D102
        @property
        def frame(self) -> str: ...  # noqa: D102
        @property
        def description(self) -> str: ...  # noqa: D102
