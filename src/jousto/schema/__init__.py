"""The model file: validated entries, built through the same constructors that Python code uses."""
