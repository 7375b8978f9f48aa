"""What a reduced part keeps beside its modes: invariants, stress modes, stiffening."""
