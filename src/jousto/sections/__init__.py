"""Cross sections of beams: areas, moments, stiffness, and the points where stress is wanted."""
