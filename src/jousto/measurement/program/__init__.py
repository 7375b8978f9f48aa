"""A monitor as a C program, for controllers beside the machine."""
