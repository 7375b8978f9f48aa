"""Measured machines: strain gauges, twins (state estimation) and monitoring."""
