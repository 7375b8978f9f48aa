"""Execution of a study: threads, processes or a cluster, and the journal of its rows."""
