"""Layout of a row of the engine: the columns of each dataset of the results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

from jousto.model.model import Model, structure_of
from jousto.model.native.header import places
from jousto.simulation.state import MEMORY, memory_sizes

DIAGNOSTICS = {
    "kinetic": ("J", "kinetic energy"),
    "strain": ("J", "strain energy of the modes"),
    "potential": ("J", "potential energy in the field of gravity"),
    "springs": ("J", "energy stored in springs and bushings"),
    "dissipated": ("J", "energy lost to modal damping and dampers since the start"),
    "friction": ("J", "energy lost to friction since the start"),
    "work": ("J", "work done by forces, torques and drives since the start"),
    "position_residual": ("m or 1", "largest position constraint residual |C|"),
    "velocity_residual": ("m/s or 1/s", "largest velocity constraint residual |Cq v|"),
    "evaluations": ("1", "evaluations of the accelerations since the start"),
    "iterations": ("1", "iterations of Newton's method since the start"),
    "steps": ("1", "steps taken since the start"),
    "rejected": ("1", "steps rejected and repeated with a shorter length since the start"),
    "step": ("s", "length of the last step"),
}


@dataclass(frozen=True)
class Column:
    """Dataset in a row of the engine: `width` columns from `first`; width None for a scalar."""

    place: str
    first: int
    width: int | None
    facts: Mapping[str, str] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of columns of the row."""
        return 1 if self.width is None else self.width


_KNOWN: WeakKeyDictionary[Model, tuple[Column, ...]] = WeakKeyDictionary()


def columns(model: Model) -> tuple[Column, ...]:
    """Return the datasets in a row of this model, in the order of the engine (cached)."""
    model = structure_of(model)
    if model not in _KNOWN:
        _KNOWN[model] = _columns(model)
    return _KNOWN[model]


def _columns(model: Model) -> tuple[Column, ...]:
    found: list[Column] = []

    def add(place: str, width: int | None, **facts: str) -> None:
        first = found[-1].first + found[-1].count if found else 0
        found.append(Column(place, first, width, facts))

    add("time", None, unit="s")
    add("state/q", model.nq, unit="m, 1, kg^0.5 m", description="[R e p] of every body")
    add(
        "state/v",
        model.nv,
        unit="m/s, rad/s, kg^0.5 m/s",
        description="[R' w_local p'] of every body",
    )
    add(
        "state/multipliers",
        model.nrow,
        unit="N or N m",
        description="lam in M a + Cq^T lam = Q, joint after joint",
    )
    for name in places("jo_diagnostics"):
        unit, description = DIAGNOSTICS[name]
        add(f"diagnostics/{name}", None, unit=unit, description=description)
    for sensor in model.sensors:
        add(
            f"sensors/{sensor.name}",
            sensor.count,
            unit=sensor.unit,
            resolved_in=sensor.resolved_in,
            description=sensor.description,
        )
    for name, width in memory_sizes(model).items():
        if width:
            unit, description = MEMORY[name]
            add(f"state/{name}", width, unit=unit, description=description)
    return tuple(found)
