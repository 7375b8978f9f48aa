"""Joints connect marker a with marker b; each declares its constraint rows as data."""
