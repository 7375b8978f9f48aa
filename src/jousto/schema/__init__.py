"""Model files: validated entries and the objects built from them."""
