"""Measured machines: gauges, twins that estimate, monitors that watch."""
