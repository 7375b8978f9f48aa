"""The formats of robots whose words are declared."""

from jousto.robots.readers.mjcf_words import MJCF
from jousto.robots.readers.sdf_words import SDF
from jousto.robots.readers.urdf_words import URDF

FORMATS = (URDF, MJCF, SDF)
