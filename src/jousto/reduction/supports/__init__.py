"""Parts held at several places: clamps, springs, their modes, static shapes and reactions."""
