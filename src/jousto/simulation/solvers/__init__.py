"""Integration methods and how they are chosen."""
