"""First-order states x' = f(t, s, s', x): control, drives, and expressions of their equations."""
