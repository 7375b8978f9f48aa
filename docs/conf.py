"""Sphinx settings; `make docs` builds with warnings as errors."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
project = "jousto"
author = "jousto contributors"
copyright = "jousto contributors"
release = installed_version("jousto")
version = release

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    # equations without a network: MathJax lies beside the pages
    "sphinx-mathjax-offline",
    "sphinx.ext.viewcode",
    # machines of the gallery that move
    "moving",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["generated"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3

# docstrings say shapes and units, so the types of the signature stay out of the way
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "imported-members": True, "ignore-module-all": False}
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
add_module_names = False
# shapes such as (n,) look like names to Sphinx and may match several attributes
suppress_warnings = ["ref.python"]

html_theme = "furo"
html_title = f"jousto {release}"
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["pages.css"]
html_search_scorer = str(Path(__file__).parent / "scorer.js")
