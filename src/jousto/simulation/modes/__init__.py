"""Modes of machines: linearised states, spectra, Campbell diagrams."""
