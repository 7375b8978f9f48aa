"""Equations of motion in natural coordinates and a step of the trapezoidal rule with them."""
