"""The formats of robots whose words are declared."""

from jousto.robots.mjcf_words import MJCF

FORMATS = (MJCF,)
