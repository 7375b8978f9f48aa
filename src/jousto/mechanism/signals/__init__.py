"""Signals in time: factors of forces, motions of drives, references of servos, inputs."""
