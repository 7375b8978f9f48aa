"""Running machine on a page: sources, requests of the page, and the user's handle."""
