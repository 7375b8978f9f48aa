"""Messages for syntax errors of YAML: line, text found, and remedy."""

from __future__ import annotations

import re

from yaml.error import Mark, MarkedYAMLError

from jousto.base.errors import Problem

NESTED = "exceeded maximum nesting depth"
"""What libyaml says of 1000 brackets in one another."""

COLON = "check the indentation and put text with a colon in quotes"
BRACKETS = "check the indentation and the brackets"
TABS = "indent with blanks, not with tabs"

SENTENCES: dict[str, tuple[str, str]] = {
    "mapping values are not allowed in this context": (
        "mapping values are not allowed here",
        COLON,
    ),
    "mapping keys are not allowed in this context": ("mapping keys are not allowed here", ""),
    "did not find expected whitespace or line break": ("expected a blank, but got {got}", ""),
    "did not find expected comment or line break": ("expected the end of the line, got {got}", ""),
    "found unknown escape character": (
        "found an escape that YAML does not have",
        "write the backslash twice, or the text in single quotes",
    ),
    "block sequence entries are not allowed in this context": (
        "an item of a list is not allowed here",
        "begin the list in a line of its own",
    ),
    "could not find expected ':'": ("could not find expected ':'", BRACKETS),
    "did not find expected key": ("expected a key, but got {got}", BRACKETS),
    "did not find expected '-' indicator": ("expected '-', but got {got}", BRACKETS),
    "did not find expected ',' or ']'": ("expected ',' or ']', but got {got}", ""),
    "did not find expected ',' or '}'": ("expected ',' or '}}', but got {got}", ""),
    "did not find expected node content": ("expected a value, but got {got}", BRACKETS),
    "did not find expected <document start>": (
        "expected the end of the file, but got {got}",
        BRACKETS,
    ),
    "found character that cannot start any token": (
        "found character {sign!r} that cannot start any token",
        "put the text in quotes",
    ),
    "found a tab character that violates indentation": ("found a tab in the indentation", TABS),
    "found a tab character where an indentation space is expected": (
        "found a tab in the indentation",
        TABS,
    ),
}
"""What messages say for each sentence of libyaml, and what to do."""

# comments, quoted texts and brackets; quotes within a word do not count
SIGNS = re.compile(
    r"""(?:^|(?<=\s))\#.*|(?<![^\s\[{,:])'(?:[^']|'')*(?:'|\Z)|(?<![^\s\[{,:])"(?:\\.|[^"\\])*(?:"|\Z)"""
    r"""|[\[\]{}]""",
    re.M,
)
PAIRS = {"]": "[", "}": "{"}


def syntax_problem(error: MarkedYAMLError, text: str, name: str) -> Problem:
    """Return the message for a syntax error of a text: line, text found, and remedy."""
    if error.problem == NESTED:
        return Problem(name, "is nested too deeply")
    mark: Mark | None = error.problem_mark or error.context_mark
    line, column = (mark.line, mark.column) if mark is not None else (0, 0)
    lines = text.split("\n")
    if line >= len(lines):  # after the last line
        line, column = len(lines) - 1, len(lines[-1])
    content = lines[line]
    rest = content[column:]
    found = str(error.problem or error.context or "cannot be read")
    sentence, remedy = SENTENCES.get(found, (found.replace("{", "{{").replace("}", "}}"), ""))
    word = re.match(r"\s*([\w./-]+|.)", rest)
    got = repr(word[1]) if word else "the end of the file" if line + 1 >= len(lines) else "its end"
    opening = unclosed([*lines[:line], content[:column]])
    if opening is not None and remedy in ("", BRACKETS):
        remedy = f"the {opening[0]} opened in line {opening[1]} is not closed"
    elif rest.startswith("\t") or "\t" in content[: len(content) - len(content.lstrip())]:
        remedy = TABS
    message = sentence.format(got=got, sign=rest[:1]) + (f"; {remedy}" if remedy else "")
    return Problem(f"{name}:{line + 1}", f"YAML syntax: {message}")


def unclosed(lines: list[str]) -> tuple[str, int] | None:
    """Return the innermost bracket or quote that is open at the end of lines, and its line.

    Examples
    --------
    >>> unclosed(["bodies: # [", "  - {name: 'a}', at: [0, 0, 0]", "  "])
    ("'{'", 2)
    """
    text = "\n".join(lines)
    opened: list[tuple[str, int]] = []
    line, counted = 1, 0
    for found in SIGNS.finditer(text):
        sign, place = found[0], found.start()
        line, counted = line + text.count("\n", counted, place), place
        if sign in ("[", "{"):
            # in a plain scalar of a block a bracket is an ordinary character
            if opened or _before_blanks(text, place) in ("", "\n", ":", "-"):
                opened.append((f"'{sign}'", line))
        elif sign in PAIRS:
            if opened and opened[-1][0] == f"'{PAIRS[sign]}'":
                opened.pop()
        elif sign[0] in "'\"" and (len(sign) == 1 or sign[-1] != sign[0]):
            opened.append(("quote", line))
    return opened[-1] if opened else None


def _before_blanks(text: str, place: int) -> str:
    """Return the last character before a place that is not blank; "" at the start of the text."""
    while place and text[place - 1] == " ":
        place -= 1
    return text[max(place - 1, 0) : place]


# characters that YAML does not allow
WRONG = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def wrong_sign(text: str, name: str) -> Problem | None:
    """Return the problem of the first character that YAML forbids; None if there is none."""
    found = WRONG.search(text)
    if found is None:
        return None
    line = text.count("\n", 0, found.start()) + 1
    return Problem(
        f"{name}:{line}", f"contains {found[0]!r}, which YAML does not allow: leave it out"
    )
