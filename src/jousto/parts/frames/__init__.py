"""Parts of beam elements: element matrices, members, stress, second-order displacements."""
