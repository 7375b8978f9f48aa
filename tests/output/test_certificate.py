"""The certificate as a page."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from jousto.base.errors import InputError
from jousto.certificate.certificate import Certificate, Silhouette
from jousto.certificate.certify import certify
from jousto.materials.material import Material
from jousto.output.pages.certificate import write_certificate
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle


@pytest.fixture(scope="module")
def certificate() -> Certificate:
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    part = Part.beam(1.0, Rectangle(0.02, 0.03), 6, steel, name="<rod> & co")
    return certify(part, reduce(part, CraigBampton(("start", "end"), modes=6)))


class Balance(HTMLParser):
    """Counts what is opened and not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_the_page_stands_for_itself(certificate: Certificate, tmp_path: Path) -> None:
    path = write_certificate(certificate, tmp_path / "rod.html")
    text = path.read_text(encoding="utf-8")
    # no network, no script
    assert not re.search(r"https?:|<script|<link|@import|url\(", text)
    assert text.count("data:image/png;base64,") == 1
    page = Balance()
    page.feed(text)
    assert page.open == []
    words = " ".join(page.words)
    assert min(map(len, (certificate.checks, certificate.facts, certificate.tables))) > 0
    for check in certificate.checks:
        assert check.topic in words and check.value in words
    for key, value in certificate.facts:
        assert key in words and value in words
    for table in certificate.tables:
        assert all(cell in words for row in table.rows for cell in row)
    # names of users are text, never markup
    assert "<rod>" not in text and "‘<rod> & co’" in words
    assert "usable" not in words and "sound" in words


def test_faults_and_remedies_stand_out(certificate: Certificate, tmp_path: Path) -> None:
    check = replace(
        certificate.checks[0], status="fail", sentence="it is held", remedy="remove supports"
    )
    bad = replace(certificate, checks=(check, *certificate.checks[1:]))
    text = write_certificate(bad, tmp_path / "bad.html").read_text(encoding="utf-8")
    assert "It is held. <b>Remove supports.</b>" in text
    assert "not to be trusted before the faults are repaired" in text


def test_a_surface_is_drawn(certificate: Certificate, tmp_path: Path) -> None:
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    shape = Silhouette(nodes, np.zeros((0, 2), int), triangles, (("foot", (0, 1, 2)),))
    solid = replace(certificate, silhouette=shape)
    empty = replace(certificate, silhouette=replace(shape, triangles=np.zeros((0, 3), int)))
    sizes = [
        len(write_certificate(c, tmp_path / "s.html").read_text(encoding="utf-8"))
        for c in (solid, empty)
    ]
    assert sizes[0] > sizes[1]


def test_where_no_page_can_be_written(certificate: Certificate, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'\.pdf' is not a format.*\.html.*print it to PDF"):
        write_certificate(certificate, tmp_path / "rod.pdf")
    with pytest.raises(InputError, match="does not exist; create it first"):
        write_certificate(certificate, tmp_path / "no" / "rod.html")
