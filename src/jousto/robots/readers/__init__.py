"""Readers of descriptions of robots: URDF, MJCF, SDF, tables of Denavit and Hartenberg."""
