"""Optimisation of flexible parts for the stresses of their motion."""
