from .studies.distributions import read_distribution as read_distribution
