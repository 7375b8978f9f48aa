"""Entries of a model file: their keys and value types.

Every file that declares the type of a field is imported here, so that the types are known whichever
of them a command imports first.
"""

from jousto.schema.entries import model as model
