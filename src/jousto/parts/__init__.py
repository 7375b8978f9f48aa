"""Parts: what a flexible body is made of, before it is reduced."""
