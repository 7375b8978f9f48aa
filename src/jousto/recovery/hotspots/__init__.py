"""Hot spots with proof: branch and bound over places and instants."""

from jousto.recovery.hotspots.search import Proof, search
from jousto.recovery.hotspots.spots import HotSpot, HotSpots, hot_spots

__all__ = ["Proof", "HotSpot", "HotSpots", "hot_spots", "search"]
