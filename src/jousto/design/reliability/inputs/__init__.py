"""Random inputs of a limit state and their standard normal space."""
