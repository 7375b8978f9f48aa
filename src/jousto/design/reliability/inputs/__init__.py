"""Random inputs of a limit state, and the standard normal space of them."""
