"""What is seen of a machine: its bodies, symbols and motion, for the browser and for pictures."""
