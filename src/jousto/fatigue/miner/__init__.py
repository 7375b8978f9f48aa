"""Damage of cycles by S-N curves, at one place and over a whole part."""
