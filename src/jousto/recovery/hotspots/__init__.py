"""Hot spots with proof: branch and bound over places and instants."""
