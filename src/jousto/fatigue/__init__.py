"""Fatigue: cycles, damage and life of stress histories."""
