"""The model file: bodies, forces, sensors and the simulation."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from jousto.mechanism.event import Event
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.initial import Initial
from jousto.reduction.damping import Rayleigh
from jousto.schema.entries import beams as beams, connections as connections
from jousto.schema.entries.base import (
    Acceleration3,
    Amount,
    Entry,
    Number,
    Position,
    Text,
)
from jousto.schema.entries.blocks.fatigue import FatigueEntry
from jousto.schema.entries.blocks.limits import ReliabilityEntry
from jousto.schema.entries.blocks.monitor import MonitorEntry
from jousto.schema.entries.choices import Later, by_form
from jousto.schema.entries.declared import FORMS, EntryOf, alone, entry_of, one_of, several
from jousto.schema.entries.sensors import SensorEntry
from jousto.schema.entries.solids import PartEntry
from jousto.schema.simulation import Simulation

# -- bodies ---------------------------------------------------------------------------------


RayleighEntry: Any = entry_of(Rayleigh)
DampingEntry: TypeAlias = Annotated[
    Annotated[Number, Tag("scalar")]
    | Annotated[tuple[Number, ...], Tag("list")]
    | Annotated[RayleighEntry, Tag("mapping")],
    by_form(),
]
FORMS.update(
    {
        "points": lambda field: dict[Text, Position],
        "damping": lambda field: DampingEntry,
        "choices": lambda field: several(Literal[field.words]),
        "file": lambda field: Text,
    }
)


def _kind_of_body(data: dict[str, Any]) -> str | None:
    if "part" in data:
        return "flexible"
    if "section" in data or "points" in data:
        return "beam"
    return "rigid" if "mass" in data or "inertia" in data else None


BodyEntry: Any = one_of(
    *("bodies", "jousto.mechanism.bodies", _kind_of_body),
    unsaid=("rigid", "flexible", "beam"),
)

# -- simulation and the whole file ----------------------------------------------------------


SimulationEntry: Any = alone(Simulation)
JOINTS = "jousto.mechanism.joints"
JointEntry: Any = one_of("joints", JOINTS)
CouplerEntry: Any = one_of("couplings", JOINTS)
FrictionEntry: Any = alone(Friction)
InitialEntry: Any = alone(Initial)
EventEntry: Any = alone(Event)
# names of unit variables with the signals connected to them
FORMS.update(
    {
        "fmu inputs": lambda field: dict[Text, Amount],
        "fmu outputs": lambda field: dict[Text, Text | None],
        "fmu parameters": lambda field: dict[Text, Amount],
        "fmu pairs": lambda field: dict[Text, Text],
    }
)
FmuEntry: Any = Annotated[Any, EntryOf("jousto.mechanism.foreign.fmu", "Fmu")]
FORMS.update(
    {
        "robot": lambda field: Text,
        "prefix": lambda field: str,
        "base": lambda field: Text,
        "robot starts": lambda field: dict[Text, Amount],
    }
)
RobotEntry: Any = Annotated[Any, EntryOf("jousto.robots.in_mechanism", "RobotInMechanism")]
ElasticJointEntry: Any = Annotated[Any, EntryOf("jousto.mechanism.elastic_joint", "ElasticJoint")]
OptimisationEntry: Any = Annotated[Any, EntryOf("jousto.schema.optimisation", "Optimisation")]
ForceEntry: Any = one_of("forces", "jousto.mechanism.forces")
StatesEntry: Any = one_of(
    "states",
    (
        "jousto.mechanism.states",
        "jousto.mechanism.hydraulics",
        "jousto.mechanism.electric",
    ),
)


class ParameterEntry(Entry):
    """Parameter: a number for ``${name}``, with its bounds and distribution for studies."""

    value: Amount
    bounds: tuple[Amount, Amount] | None = Field(None, description="Smallest and largest value")
    distribution: Text | None = Field(
        None, description="Distribution of the value, such as lognormal(mean=1 kN, sd=100 N)"
    )


ParameterForm: TypeAlias = Annotated[
    Annotated[Amount, Tag("scalar")] | Annotated[ParameterEntry, Tag("mapping")], by_form()
]


class ModelEntry(Entry):
    """A jousto model."""

    schema_: Text | None = Field(None, alias="$schema", description="For editors, not used")
    name: Text | None = None
    parameters: dict[Text, ParameterForm] | None = Field(
        None, description="Numbers that ${name} and ${2 * name + 1 mm} stand for"
    )
    parts: dict[Text, PartEntry] | None = None
    bodies: tuple[BodyEntry, ...]
    robots: tuple[RobotEntry, ...] | None = None
    joints: tuple[JointEntry, ...] | None = None
    elastic_joints: tuple[ElasticJointEntry, ...] | None = None
    couplings: tuple[CouplerEntry, ...] | None = None
    forces: tuple[ForceEntry, ...] | None = None
    states: tuple[StatesEntry, ...] | None = None
    frictions: tuple[FrictionEntry, ...] | None = None
    initial: tuple[InitialEntry, ...] | None = None
    gravity: Acceleration3 | None = None
    sensors: tuple[SensorEntry, ...] | None = None
    events: tuple[EventEntry, ...] | None = None
    fmus: tuple[FmuEntry, ...] | None = None
    simulation: SimulationEntry | None = None
    fatigue: Annotated[FatigueEntry, Later()] | None = None
    monitor: MonitorEntry | None = None
    limits: tuple[Text, ...] | None = Field(
        None, description="Outcomes and their bounds, such as max(tip.y) <= 12 mm"
    )
    reliability: ReliabilityEntry | None = None
    optimisation: OptimisationEntry | None = None
