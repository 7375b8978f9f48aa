"""Reference conditions: the motion of the frame of a flexible body relative to its deformation."""
