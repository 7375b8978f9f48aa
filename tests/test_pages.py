"""The pages of the documentation: their kinds, their groups, their length, and what a search finds.

Each page of docs/ declares its kind in its front matter: a *guide* shows how to do something, a
*reference* has tables of everything there is, *theory* has equations, proofs and measurements.
"""

from __future__ import annotations

import json
import re
import warnings
from collections import Counter
from pathlib import Path

import pytest

DOCS = Path(__file__).parent.parent / "docs"
PAGES = {str(path.relative_to(DOCS))[:-3]: path for path in sorted(DOCS.rglob("*.md"))}
KINDS = ("guide", "reference", "theory")
WORDS = 1500  # of a guide, besides its code
GROUP = 8  # pages of a group in the side bar
WIDTH = (
    108  # characters of a line of code, what fits a window of 1200 pixels (docs/static/pages.css)
)
FOLDED = 118  # of folded outputs, in smaller letters
TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.M | re.S)
CODE = re.compile(r"^```.*?^```$", re.M | re.S)
FOUND = {  # what users look for, and the page whose headings have it
    "contact": "instead",
    "wheel": "multiaxial",
    "gear": "mechanisms",
    "cable": "exact-beams",
    "spring": "forces",
    "motor": "forces",
    "PID": "controllers",
    "gravity": "forces",
    "units": "model-file",
    "STEP": "meshes",
    "Abaqus": "beam-decks",
    "life": "gallery-stress",
    "gauge": "gauges",
    "FMU": "fmu-import",
    "URDF": "robots",
    "parallel": "studies",
}


def front(text: str) -> dict[str, str]:
    """Return what the front matter of a page declares."""
    if not (match := re.match(r"---\n(.*?)^---\n", text, re.M | re.S)):
        return {}
    return dict(re.findall(r"^(\w+): (.*)$", match[1], re.M))


def words(text: str) -> int:
    """Count the words of a page outside its front matter and its code, those of tables too."""
    text = CODE.sub("", re.sub(r"\A---\n.*?^---\n", "", text, flags=re.M | re.S))
    return len(re.findall(r"\S*\w\S*", text))


def groups() -> dict[str, list[str]]:
    """Return the pages of each group of the side bar by its page, place and caption."""
    found = {}
    for page, path in PAGES.items():
        for number, body in enumerate(TOCTREE.findall(path.read_text(encoding="utf-8"))):
            caption = re.search(r"^:caption: (.*)$", body, re.M)
            names = [line for line in body.splitlines() if line and not line.startswith(":")]
            folder = f"{page.rpartition('/')[0]}/".lstrip("/")
            found[f"{page} {number} {caption[1] if caption else ''}"] = [folder + n for n in names]
    return found


@pytest.mark.parametrize("page", PAGES)
def test_the_page_declares_its_kind_and_a_guide_is_short(page: str) -> None:
    text = PAGES[page].read_text(encoding="utf-8")
    kind = front(text).get("kind")
    assert kind in KINDS
    if kind == "guide":
        assert words(text) < WORDS


def test_every_page_is_in_one_group_of_at_most_eight() -> None:
    found = groups()
    assert {name: len(pages) for name, pages in found.items() if len(pages) > GROUP} == {}
    counts = Counter(page for pages in found.values() for page in pages)
    assert {page for page, count in counts.items() if count > 1} == set()
    assert set(counts) == set(PAGES) - {"index"}
    captions = [name for name in found if name.startswith("index ")]
    assert len(captions) > 8 and all(re.fullmatch(r"index \d+ \S.*", name) for name in captions)


def test_words_and_groups_are_counted() -> None:
    head = "---\nkind: guide\n---\n\n# A page\n\n"
    text = f"{head}three plain words\n\n```text\nnot these\n```\n\n| a | b |\n"
    assert front(text) == {"kind": "guide"}
    assert words(text) == 2 + 3 + 2
    assert words(PAGES["theory-bodies"].read_text(encoding="utf-8")) > WORDS
    line = "x" * 110
    assert too_wide(f"```text\n{line}\n```\n") == [line]
    assert too_wide(f"<details>\n```text\n{line}\n```\n</details>\n") == []
    assert "api/parts" in [page for pages in groups().values() for page in pages]


@pytest.mark.parametrize("page", PAGES)
def test_code_of_the_page_fits_a_window(page: str) -> None:
    text = PAGES[page].read_text(encoding="utf-8")
    assert too_wide(text) == []


def too_wide(text: str) -> list[str]:
    """Return the lines of code of a page that a window cuts off; those of patches are wrapped."""
    folded = [range(*match.span()) for match in re.finditer("<details>.*?</details>", text, re.S)]
    lines = []
    for block in CODE.finditer(text):
        if block[0].startswith(("```diff", "```{eval-rst}")):
            continue
        limit = FOLDED if any(block.start() in place for place in folded) else WIDTH
        lines += [line for line in block[0].splitlines() if len(line) > limit]
    return lines


def anchors(text: str) -> set[str]:
    """Return the names that links to the headings of a page have."""
    headings = re.findall(r"^#+ (.*)$", CODE.sub("", text), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", [*PAGES, "../README", "../CHANGELOG", "../CONTRIBUTING"])
def test_links_to_sections_exist(page: str) -> None:
    path = (DOCS / f"{page}.md").resolve()
    text = path.read_text(encoding="utf-8")
    missing = []
    for target, anchor in re.findall(r"\]\(([\w./-]*)#([\w-]+)\)", text):
        other = path.parent / target if target else path
        if anchor not in anchors(other.read_text(encoding="utf-8")):
            missing.append(f"{target}#{anchor}")
    assert missing == []


def test_a_link_to_a_missing_section_is_seen() -> None:
    assert anchors("# What `a` is\n\n```text\n# not this\n```\n\n## Bars, 2 of them\n") == {
        "what-a-is",
        "bars-2-of-them",
    }


@pytest.fixture(scope="module")
def index(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    """Return the search index that Sphinx builds of the pages, without those of the API."""
    pytest.importorskip("sphinx")
    pytest.importorskip("myst_parser")
    from sphinx.application import Sphinx
    from sphinx.util.docutils import docutils_namespace

    out = tmp_path_factory.mktemp("pages")
    settings = {
        "extensions": ["myst_parser"],
        "exclude_patterns": ["api"],
        "html_theme": "basic",
        "myst_enable_extensions": ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"],
        "source_suffix": {".md": "markdown"},
        "html_copy_source": False,
    }
    with docutils_namespace(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what Sphinx and its extensions say of one another
        app = Sphinx(
            DOCS, None, out / "html", out / "trees", "html", settings, status=None, warning=None
        )
        app.build()
    text = (out / "html" / "searchindex.js").read_text(encoding="utf-8")
    return json.loads(re.fullmatch(r"Search\.setIndex\((.*)\)", text)[1])


@pytest.mark.parametrize("word", FOUND)
def test_the_index_of_words_has_it(word: str) -> None:
    """It stands first in the results of a search, see docs/scorer.js."""
    text = PAGES["find"].read_text(encoding="utf-8")
    words = re.findall(r"^\| (.*?) \|", text, re.M)
    assert any(re.search(rf"\b{word}s?\b", line, re.I) for line in words)


@pytest.mark.parametrize(("word", "page"), FOUND.items())
def test_a_search_finds_the_page(index: dict[str, object], word: str, page: str) -> None:
    from sphinx.search.en import SearchEnglish

    stem = SearchEnglish({}).stem(word.lower())
    assert stem in index["titleterms"], f"no heading has {word}"
    numbers = index["titleterms"][stem]
    names = [index["docnames"][k] for k in (numbers if isinstance(numbers, list) else [numbers])]
    # words of headings come first in the list of a search; a long list hides the page
    assert page in names and len(names) <= 12
