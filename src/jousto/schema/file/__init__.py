"""A model file: reading, lines, explaining what is wrong."""
