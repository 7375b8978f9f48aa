"""Viewer: a page in the browser, its server, self-contained pages, notebook cells."""
