"""The formats of robots whose words are declared."""

from jousto.robots.mjcf_words import MJCF
from jousto.robots.sdf_words import SDF
from jousto.robots.urdf_words import URDF

FORMATS = (URDF, MJCF, SDF)
