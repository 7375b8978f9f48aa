"""Live machines: external inputs, drag spring, real-time clock, recorder."""
