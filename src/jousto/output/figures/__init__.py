"""Figures: histories, spectra, hot spots, damage and gauges as plots."""
