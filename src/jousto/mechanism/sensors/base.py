"""Base of all sensors: the sensor, its reading and its rainflow counts."""

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
    """Input of the engine for a sensor, with objects in place of their numbers in the engine.

    Parameters
    ----------
    kind : str
        Name of the sensor in the header of the engine, ``jousto.h``.
    of : object
        Object that is measured: a marker, body, joint, coupling, force, friction, coordinate,
        signal, beam, damage sensor or the name of an energy.
    other : Marker, Signal or int, optional
        Observer, added signal, or index of the first value.
    axes : Marker, optional
        Axes of the values; None for the world frame.
    rows : (k, n) array, optional
        Values per unit modal coordinate.
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
    """Rainflow count of the engine: its rule, and the counted value of a sensor.

    Parameters
    ----------
    rule : MeterRule
        S-N curve, mean stress correction and residue.
    sensor : Sensor Sensor that is counted.
    value : int
        Index of the counted value.
    factor : float
        Stress, Pa, per unit of the value.
    """

    rule: Any
    sensor: Sensor
    value: int
    factor: float


class Sensor(Declared, section="sensors"):
    """Base of the quantities that the engine records.

    Attributes
    ----------
    unit : str
        Unit of the components; two units separated by a comma apply to the first and second half of
        the components.
    components : tuple of str
        Names of the components.
    frame : str
        Name of the axes in which they are resolved.
    description : str
        One line for results and plots.
    reading : Reading
        Input of the engine.
    """

    kind = "sensor"
    flexible: ClassVar[bool] = False
    """Whether it measures deformation (modes, stress, strain), which rigid bodies do not have."""
    name: Name = field("Unique among the sensors")

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the argument."""
        return ()

    @property
    def meters(self) -> tuple[Meter, ...]:
        """Rainflow counts of the engine for the sensor."""
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
