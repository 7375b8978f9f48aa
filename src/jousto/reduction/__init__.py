"""REDUCE: a part with a mesh becomes a few modes, invariants and modal stress."""
