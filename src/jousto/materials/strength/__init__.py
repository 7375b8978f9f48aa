"""Strength: S-N and strain-life curves, mean stress, factors of surface and size, welds."""
