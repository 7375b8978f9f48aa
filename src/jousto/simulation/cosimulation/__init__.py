"""Functional mock-up units beside the engine: their process, the exchange, its energy."""
