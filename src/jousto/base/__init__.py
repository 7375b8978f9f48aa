"""Base of all rooms, without mechanics: errors, checks, files, units."""
