"""Functional mock-up units beside the engine: process of a unit, exchange of values, energy."""
