"""The viewer: a page in the browser, its server, pages that stand alone, and cells of notebooks."""
