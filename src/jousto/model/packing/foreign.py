"""Models of other programs: indices of exchanged values, and checks where they are unsupported."""

from __future__ import annotations

from jousto.base.errors import InputError, Problem
from jousto.mechanism.mechanism import Mechanism
from jousto.model.model import FmuModel, Model, SensorModel


def fmu_models(mechanism: Mechanism, sensors: tuple[SensorModel, ...]) -> tuple[FmuModel, ...]:
    """Return the models of other programs in a mechanism; `sensors` are those of the model."""
    offsets = {id(s): m.offset for s, m in zip(mechanism.sensors, sensors, strict=False)}
    made = []
    for fmu in mechanism.fmus:
        links = fmu.inputs.items()
        measured = {k: offsets[id(v[0])] + v[1] for k, v in links if isinstance(v, tuple)}
        given = {k: float(v) for k, v in links if not isinstance(v, tuple)}
        set_ = {k: v.name for k, v in fmu.outputs.items() if v is not None}
        made.append(FmuModel(fmu, measured, given, set_))
    return tuple(made)


def without_fmus(model: Model | Mechanism, where: str, why: str) -> None:
    """Raise InputError if a model contains models of other programs.

    Raises
    ------
    InputError
        If the model has one.
    """
    names = [x.fmu.name if isinstance(x, FmuModel) else x.name for x in model.fmus]
    if names:
        raise InputError(
            [
                Problem(
                    where,
                    f"fmu {name!r} {why}; only jo.simulate supports it; leave it out and give "
                    f"values to the inputs that it sets",
                )
                for name in names
            ]
        )
