"""Parts held at several places: clamps, springs, modes, static shapes and reactions."""
