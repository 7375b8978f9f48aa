"""Replacement of external inputs by signals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from jousto.mechanism.signals.base import Signal
from jousto.model.model import Model, SignalModel
from jousto.model.packing.builder import Builder


def substitute(model: Model, signals: Mapping[str, Signal]) -> Model:
    """Return the model with signals of time in place of named inputs.

    The engine then evaluates them at every stage of a step, like other signals of the model.
    """
    if not signals:
        return model
    models: list[SignalModel] = []
    further: list[SignalModel] = []
    inputs = 0
    for signal in model.signals:
        if signal.kind != "input":
            models.append(signal)
        elif signal.name not in signals:
            models.append(replace(signal, count=inputs))
            inputs += 1
        else:
            builder = Builder({})
            top = builder.signal(signals[signal.name])
            first = len(model.signals) + len(further)
            made = [_moved(other, first) for other in builder.signals]
            further += made
            models.append(made[top])
    return replace(model, signals=(*models, *further))


def _moved(signal: SignalModel, first: int) -> SignalModel:
    """Return the signal with the indices of its terms increased by `first`."""
    if signal.kind not in ("sum", "product"):
        return signal
    a, b = signal.children
    return replace(signal, children=(a + first, b + first))
