"""Stress at the toes of welds."""
