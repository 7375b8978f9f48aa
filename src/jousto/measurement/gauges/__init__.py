"""Gauges: what rosettes say, and measured records."""
