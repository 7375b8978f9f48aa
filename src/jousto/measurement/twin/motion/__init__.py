"""What moves a part: the motion of its frame as one linear model with its modes."""
