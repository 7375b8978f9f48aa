"""Fields of a reduced part besides its modes: invariants, stress modes, stiffening."""
