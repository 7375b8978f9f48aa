"""Signals of time: factors on forces, motions of drives, references of servos, inputs."""
