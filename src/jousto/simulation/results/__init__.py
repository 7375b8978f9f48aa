"""Results of a run: solution, records in memory and in files, tables."""
