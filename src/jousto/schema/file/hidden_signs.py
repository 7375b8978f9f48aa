"""Replace characters that only libyaml interprets before parsing, and restore them after it."""

from __future__ import annotations

import re

EXPRESSION = re.compile(r"\$\{([^{}\n]*)\}")

SHIELD = 0xE000  # start of Unicode's private area, to which replaced characters are moved
BREAKS = re.compile("[\x85\u2028\u2029]")  # line ends of YAML 1.1 that YAML 1.2 does not have
SHIELDED = re.compile("[\ue020-\ue07e\ue085\uf028\uf029]")
MOVED = {0x85: 0xE085, 0x2028: 0xF028, 0x2029: 0xF029}
RESTORED = {new: old for old, new in MOVED.items()}
RESTORED |= {SHIELD + k: k for k in range(0x20, 0x7F)}

ESCAPE = "\uf0d8"  # replaces the backslash of the escapes below
# escaped surrogates, which libyaml refuses, and escapes of replaced characters
ESCAPES = re.compile(r"(?<!\\)((?:\\\\)*)\\(?=u(?:[dD][89a-fA-F]|[eEfF]0)[0-9a-fA-F]{2})")
HIDDEN_ESCAPE = re.compile(ESCAPE + "u([0-9a-fA-F]{4})")
SURROGATE = re.compile("[\ud800-\udfff]")  # surrogates, which UTF-8 cannot encode
UTF16 = "utf-16-le"


def shielded(text: str) -> str:
    """Return text with replaced characters in ``${...}`` and of YAML 1.1 only; `bare` undoes it."""
    if not text.isascii() and (SHIELDED.search(text) or ESCAPE in text):
        return text
    if "${" in text:
        text = EXPRESSION.sub(lambda found: "$" + "".join(map(_shield, found[0][1:])), text)
    if "\\u" in text:
        text = ESCAPES.sub(lambda found: found[1] + ESCAPE, text)
    if not text.isascii() and BREAKS.search(text):
        text = text.translate(MOVED)
    return text


def _shield(sign: str) -> str:
    plain = sign.isalnum() or sign == " " or not " " < sign <= "~"
    return sign if plain else chr(SHIELD + ord(sign))


def bare(text: str) -> str:
    """Return the original text of `shielded` text."""
    return text.translate(RESTORED) if SHIELDED.search(text) else text
