"""Joints connect marker a to marker b; each declares its constraint rows as data."""
