"""Reference conditions, which define the frame of a flexible body relative to its deformation."""
