"""From entries to objects."""
