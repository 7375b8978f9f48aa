"""Running a model: simulate, the simulator, states, inputs, progress."""
