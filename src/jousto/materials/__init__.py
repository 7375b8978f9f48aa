"""Materials: elastic constants, density, and in `strength` what they endure."""
