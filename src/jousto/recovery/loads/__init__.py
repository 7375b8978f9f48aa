"""Loads on a body during a run: joints, forces, friction, gravity, inertia and elastic forces."""
