"""Sphinx settings; `make docs` builds with warnings as errors."""

from __future__ import annotations

import re
import sys
from importlib.metadata import version as installed_version
from operator import attrgetter
from pathlib import Path
from typing import Any

import jousto as jo
from jousto.base.rooms import public_names

sys.path.insert(0, str(Path(__file__).parent))
from tables import filled

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


def entries_of_rooms(app: Any, page: str, source: list[str]) -> None:
    """Replace ``PUBLIC rooms`` in a page by the help of their public names, fill its tables."""

    def entries(match: re.Match[str]) -> str:
        rooms = tuple(f"jousto.{room}." for room in match[1].split())
        lines = []
        for place in sorted(public_names(), key=lambda place: (place.count("."), place)):
            thing = attrgetter(place.removeprefix("jo."))(jo)
            module = getattr(thing, "__module__", "")
            if f"{module}.".startswith(rooms):
                kind = "class" if isinstance(thing, type) else "function"
                if not callable(thing):
                    kind = "data"
                lines.append(f"``{place}``")
                lines.append(f".. auto{kind}:: {module}.{place.rpartition('.')[2]}")
        return "\n\n".join(lines)

    source[0] = filled(re.sub(r"^PUBLIC (.+)$", entries, source[0], flags=re.M))


def setup(app: Any) -> None:
    """Connect what this project adds to Sphinx."""
    app.connect("source-read", entries_of_rooms)
