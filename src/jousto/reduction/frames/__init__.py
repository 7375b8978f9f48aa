"""Reference conditions: how the frame of a flexible body follows it."""
