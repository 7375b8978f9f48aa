"""Damage of random stress from spectra."""
