"""Design for a target of reliability."""
