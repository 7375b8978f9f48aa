"""A running machine on a page: what is opened, what the page may ask, and the handle of both."""
