"""Bodies, their markers, inertia and shapes."""
