"""What all sensors share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.fields import Name, field
from jousto.base.object_repr import described
from jousto.mechanism.bodies.marker import Marker


@described
@dataclass(frozen=True, eq=False)
class Reading:
    """What the engine reads for a sensor, with objects instead of their numbers in the engine.

    Parameters
    ----------
    kind : str
        Name of the sensor in the header of the engine, ``jousto.h``.
    of : object
        What is read: a marker, body, joint, coupling, force, friction, coordinate, signal, beam,
        damage sensor or the word of an energy.
    other : Marker, Signal or int, optional
        The observer, the signal that is added, or the place of the first value.
    axes : Marker, optional
        Axes of the values; None for those of the world.
    rows : (k, n) array, optional
        Values of each mode.
    at : int
        Number of the element of a beam.
    """

    kind: str
    of: Any
    other: Any = None
    axes: Marker | None = None
    rows: Array | None = None
    at: int = 0


@described
@dataclass(frozen=True, eq=False)
class Meter:
    """A rainflow count of the engine: its rule, and which value of a sensor it counts.

    Parameters
    ----------
    rule : MeterRule
        Curve, mean stress, residue.
    sensor : Sensor
        What is counted.
    value : int
        Which of its values.
    factor : float
        Stress, Pa, for a value of 1.
    """

    rule: Any
    sensor: Sensor
    value: int
    factor: float


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
    reading : Reading
        What the engine reads.
    """

    kind = "sensor"
    flexible: ClassVar[bool] = False
    """Whether it measures what rigid bodies do not have: modes, stress, strain."""
    name: Name = field("Unique among the sensors")

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """The markers whose orientation matters, with the name of the argument."""
        return ()

    @property
    def meters(self) -> tuple[Meter, ...]:
        """The rainflow counts that the engine keeps for it."""
        return ()

    if TYPE_CHECKING:

        @property
        def unit(self) -> str: ...  # noqa: D102
        @property
        def components(self) -> tuple[str, ...]: ...  # noqa: D102
        @property
        def frame(self) -> str: ...  # noqa: D102
        @property
        def description(self) -> str: ...  # noqa: D102
        @property
        def reading(self) -> Reading: ...  # noqa: D102
