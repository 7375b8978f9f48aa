"""RECOVER: fields over a body from the few coordinates that a run stores."""
