"""Words of a format and their treatment by a reader, for readers, tests and documentation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from jousto.base.errors import suggest
from jousto.robots.readers.xml import Element, Reading

DONE, QUIET, WARNED, REFUSED = "done", "no effect", "warned of", "refused"
TREATMENTS = (DONE, QUIET, WARNED, REFUSED)


@dataclass(frozen=True)
class Word:
    """Treatment of an attribute or an element by a reader.

    Parameters
    ----------
    treatment : {"done", "no effect", "warned of", "refused"}
        Treatment; "no effect" means no effect on the motion.
    text : str
        Effect, for a warning, or remedy, for an error.
    unless : tuple of str
        Values of an attribute without effect, which are not reported: a word, or a number to which
        all numbers of the value are equal.
    silent : bool
        Whether the word is not reported here, since the reader reports all words of its kind once.
    """

    treatment: str
    text: str = ""
    unless: tuple[str, ...] = ()
    silent: bool = False

    def counts(self, value: str) -> bool:
        """Return whether a value of the attribute has an effect."""
        for idle in self.unless:
            if value.strip() == idle:
                return False
            try:
                if value.split() and all(float(x) == float(idle) for x in value.split()):
                    return False
            except ValueError:
                continue
        return True


def warned(text: str, *unless: str, silent: bool = False) -> Word:
    """Return the treatment of a word with a warning of its effect."""
    return Word(WARNED, text, unless, silent)


def refused(text: str, *unless: str) -> Word:
    """Return the treatment of a word that is an error, with its remedy."""
    return Word(REFUSED, text, unless)


@dataclass(frozen=True)
class Tag:
    """Treatment of an element and of the words in it by a reader.

    Parameters
    ----------
    done, quiet : str
        Attributes, and children whose attributes have no effect, separated by spaces.
    words : dict of str to Word
        Words with a warning or an error; several with the same treatment under one key, separated
        by spaces.
    whole : Word or None
        Treatment of the element with all its contents; None if each word has its own.
    free : bool
        Whether words of other programs are allowed here and not reported.
    """

    done: str = ""
    quiet: str = ""
    words: Mapping[str, Word] = field(default_factory=dict)
    whole: Word | None = None
    free: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "_known", dict(self.all()))

    def word(self, name: str) -> Word | None:
        """Return the treatment of a word, or None if it is not declared."""
        known: dict[str, Word] = vars(self)["_known"]
        return known.get(name)

    def all(self) -> Iterator[tuple[str, Word]]:
        """Yield the words and their treatments."""
        for name in self.done.split():
            yield name, Word(DONE)
        for name in self.quiet.split():
            yield name, Word(QUIET)
        for names, word in self.words.items():
            for name in names.split():
                yield name, word


QUIET_TAG = Tag(whole=Word(QUIET))


@dataclass(frozen=True)
class Format:
    """Words of a format.

    Parameters
    ----------
    name : str
        Name of the format.
    tags : dict of str to Tag
        Treatments by ``parent/element``; ``*/element`` is for any other parent.
    same : dict of str to str
        Parents with the same children as another parent.
    """

    name: str
    tags: Mapping[str, Tag]
    same: Mapping[str, str] = field(default_factory=dict)

    def tag(self, parent: str, name: str) -> Tag | None:
        """Return the treatment of an element below a parent; None if it is not declared."""
        parent = self.same.get(parent, parent)
        return self.tags.get(f"{parent}/{name}") or self.tags.get(f"*/{name}")

    def treatment(self, path: Sequence[str], word: str) -> Word | None:
        """Return the treatment of a word of an element, None if it is not declared.

        Parameters
        ----------
        path : sequence of str
            Names of the elements from the root to the element.
        word : str
            Name of an attribute, or of a child without own words.
        """
        parent, tag = "", Tag()
        for name in path:
            below = self.tag(parent, name)
            if below is None:
                return tag.word(
                    name
                )  # a child that is declared as a word of its parent, with all its contents
            if below.whole is not None:
                return below.whole
            parent, tag = name, below
        below = self.tag(parent, word)
        return tag.word(word) if below is None else below.whole or Word(DONE)


def check_words(reading: Reading, root: Element, words: Format, parent: str = "") -> None:
    """Report all words of an element and its children with an error or warning, or unknown."""
    waiting = [(root, words.tag(parent, root.tag) or Tag())]
    while waiting:
        element, tag = waiting.pop()
        if tag.whole is not None:
            _report(reading, element, f"<{element.tag}>", tag.whole)
            continue
        for name, value in element.given.items():
            word = tag.word(name)
            if word is not None:
                if word.counts(value):
                    _report(reading, element, name, word)
            elif ":" not in name and not tag.free:  # words of other programs have a namespace
                known = [known for known, _ in tag.all()]
                reading.note(element, f"{name!r} is not read{suggest(name, known)}")
        for child in reversed(element.children):
            below, word = words.tag(element.tag, child.tag), tag.word(child.tag)
            if below is not None:
                waiting.append((child, below))
            elif word is None:
                if ":" not in child.tag and not tag.free:
                    reading.leave_out(child)
            elif word.counts(child.text):
                _report(reading, child, f"<{child.tag}>", word)


def _report(reading: Reading, element: Element, name: str, word: Word) -> None:
    if word.silent or word.treatment in (DONE, QUIET):
        return
    if word.treatment == REFUSED:
        reading.add(element, f"{name} {word.text}")
    else:
        reading.effect(element, name, word.text)
