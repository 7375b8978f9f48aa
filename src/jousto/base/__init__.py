"""What every room uses and what knows nothing of mechanics: errors, checks, files, units."""
