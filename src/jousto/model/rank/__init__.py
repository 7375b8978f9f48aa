"""Which constraints depend on others, and what a mechanism can do with its freedoms."""
