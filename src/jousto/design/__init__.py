"""Design: studies of many runs, optimisation, and probabilities of failure."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
