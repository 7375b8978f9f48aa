"""Damage of stress states whose directions turn: critical planes."""
