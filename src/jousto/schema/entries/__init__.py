"""Entries of a model file: which keys they have and which values.

Every file that declares the type of a field is imported here, so that the types are known whichever
of them a command imports first.
"""

from jousto.schema.entries import model as model
