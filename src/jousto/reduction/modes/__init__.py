"""Eigenproblems: constraint, fixed-interface and free modes, ties and rigid motions."""
