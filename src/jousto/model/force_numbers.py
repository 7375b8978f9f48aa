"""Numbers of a force by their names in the header of the engine."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.mechanism.forces.law import EngineLaw
from jousto.model.model import ForceModel
from jousto.model.native.header import named, places


def struct_of(kind: str) -> str:
    """Return the name of the struct of a law's numbers, such as ``jo_modal_load_data``."""
    return f"jo_{kind.replace(' ', '_')}_data"


def numbers_of(force: ForceModel) -> Any:
    """Return the numbers of a force as attributes."""
    return named(struct_of(force.kind), force.data)


def with_number(force: ForceModel, name: str, value: float) -> NDArray[np.float64]:
    """Return the numbers of a force with another value of one of them."""
    data = np.array(force.data)
    data[places(struct_of(force.kind))[name]] = value
    return data


def law_in(force: ForceModel) -> EngineLaw:
    """Return the declared law of a force model with the numbers of the model."""
    return force.law.with_numbers(numbers_of(force))
