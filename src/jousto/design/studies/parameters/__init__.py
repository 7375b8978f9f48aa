"""Parameters of a study, their distributions, and samples of them."""
