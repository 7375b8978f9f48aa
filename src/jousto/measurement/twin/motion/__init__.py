"""Motion of a part: its frame motion and its modes as one linear model."""
