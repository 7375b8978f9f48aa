"""Hydraulic networks: nodes, cylinders, valves, pumps and lines that become states of a machine."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
