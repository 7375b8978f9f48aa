"""Bands of stress and damage from estimated modes."""
