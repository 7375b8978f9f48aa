"""The model file: validated entries, built through the same constructors that Python code uses."""

from jousto.schema.read import (
    ModelFile,
    Simulation,
    model_schema,
    parse_model,
    read_model,
    read_part,
)

__all__ = ["ModelFile", "Simulation", "read_model", "read_part", "model_schema", "parse_model"]
