"""PROGRAM: a monitor as a program of C, for controllers beside the machine."""
