"""Bodies that touch: shapes, laws of contact, and contacts between two markers."""
