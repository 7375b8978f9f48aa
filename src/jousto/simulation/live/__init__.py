"""Machines that run while somebody looks: inputs, a hand that pulls, a clock, a record."""
