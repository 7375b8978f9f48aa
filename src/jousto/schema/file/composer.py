"""YAML text to a tree of nodes with lines: by libyaml where it reads as ruamel.yaml does.

ruamel.yaml reads YAML 1.2 and says what is wrong, 2 ms for each body of a model. libyaml, in C,
reads YAML 1.1, with the same structure for usual text; what plain words mean is decided by the
rules of ruamel.yaml for 1.2. Unusual text and all text with an error is left to ruamel.yaml.
"""

from __future__ import annotations

import functools
import operator
import re
from itertools import accumulate
from typing import Any

from jousto.base.garbage_collection import uncollected

# searched one by one, since each begins with a sign that Python looks for quickly
UNUSUAL = (
    # tabs, line ends of YAML 1.1 alone, signs that are none
    re.compile("[\t\x85\u2028\u2029\ufeff\x00-\x08\x0b-\x1f]"),
    # directives
    re.compile("%(?<=^%)", re.M),
    # anchors, aliases, tags, text in blocks, keys of several lines
    re.compile(r"[&*!|>?](?:(?<=[\s\[\]{},:].)|(?<=^.))", re.M),
    # signs of deep nesting by indentation
    re.compile("[- :]{300}(?<=^.{300})", re.M),
)
DEEP = 100  # brackets within brackets; libyaml's tree is made by recursion in C


def compose(text: str) -> Any:
    """Return the root node of the one document of a text, None if it is empty.

    Raises
    ------
    ruamel.yaml.error.YAMLError
        If the text is no YAML.
    RecursionError
        If it is nested too deeply.
    """
    read = _libyaml()
    plain = text.replace("\r\n", "\n")
    if read is not None and not _is_unusual(plain):
        import yaml

        try:
            return read(plain)
        except yaml.YAMLError:
            pass  # ruamel.yaml tells what is wrong, or reads it
    from ruamel.yaml import YAML

    return YAML(typ="rt", pure=True).compose(text)


def _is_unusual(text: str) -> bool:
    """Return whether libyaml may read a text in another way, or fail at it."""
    return any(sign.search(text) for sign in UNUSUAL) or _depth(text) > DEEP


def _depth(text: str) -> int:
    """Return how deep brackets are nested at the most, those in quotes included."""
    steps = (1 if sign in "[{" else -1 for sign in re.findall(r"[\[\]{}]", text))
    return max(accumulate(steps), default=0)


@functools.cache
def _libyaml() -> Any:
    """Return the function that composes by libyaml, None where there is none."""
    try:
        from yaml.cyaml import CParser
    except ImportError:  # PyYAML without libyaml
        return None
    from ruamel.yaml.resolver import implicit_resolvers
    from yaml.resolver import Resolver

    class Words(Resolver):  # type: ignore[misc]
        """What plain words mean in YAML 1.2."""

        yaml_implicit_resolvers: dict[str, list[Any]] = {}

    for versions, tag, pattern, first in implicit_resolvers:
        if (1, 2) in versions:
            for letter in first:
                known = Words.yaml_implicit_resolvers.setdefault(letter, [])
                known.append((tag, re.compile(pattern.pattern, pattern.flags)))

    class Loader(CParser):  # type: ignore[misc]
        # tags do not depend on where a node stands; functions in C cost the least
        descend_resolver = staticmethod(operator.is_)
        ascend_resolver = staticmethod(tuple)

        def __init__(self, text: str) -> None:
            super().__init__(text)
            self.resolve = functools.cache(Words().resolve)  # the words of a model repeat

    def read(text: str) -> Any:
        loader = Loader(text)
        try:
            with uncollected():
                return loader.get_single_node()
        finally:
            loader.dispose()

    return read
