"""HTML pages: certificates of parts, verifications and optimisations."""
