"""Equilibrium, load paths, buckling and starts without vibration."""
