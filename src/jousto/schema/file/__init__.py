"""Reader of model files: content, line numbers, error messages."""
