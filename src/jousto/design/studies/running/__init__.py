"""Runs of a study: variants in threads, processes or on a cluster, and the journal of them."""
