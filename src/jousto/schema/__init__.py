"""The model file: validated entries, built through the same constructors that Python code uses."""

from jousto.schema.read import (
    ModelFile,
    PartFile,
    Simulation,
    model_schema,
    parse_model,
    read_model,
    read_part,
    read_part_file,
)

__all__ = [
    "ModelFile",
    "PartFile",
    "Simulation",
    "model_schema",
    "parse_model",
    "read_model",
    "read_part",
    "read_part_file",
]
