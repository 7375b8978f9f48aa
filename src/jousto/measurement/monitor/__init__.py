"""Monitoring: measured strains to stress, damage and remaining life while they come."""
