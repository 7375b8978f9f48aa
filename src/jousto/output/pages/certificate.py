"""Certificate of a part as one HTML page without network or script, fit for printing."""

from __future__ import annotations

import html
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.certificate.certificate import Certificate, Check, Silhouette, Table
from jousto.output.pages.html_page import (
    badge,
    document,
    facts_table,
    image_address,
    number_table,
    write_page,
)
from jousto.output.style import COLORS, INK, MUTED, PAPER, Picture, styled

WORDS = {"ok": "ok", "note": "note", "warn": "warning", "fail": "fault"}
MOST_ROWS = 24  # rows shown of a table
VERDICT = {
    "ok": "sound",
    "warn": "usable, read the warnings",
    "fail": "not to be trusted before the faults are repaired",
}


@explained_as("write")
def write_certificate(certificate: Certificate, path: str | Path) -> Path:
    """Write a certificate as a self-contained HTML page without network or script.

    Parameters
    ----------
    certificate : Certificate
        Result of `certify`.
    path : str or Path
        File that ends in ``.html``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For another ending, a folder that does not exist, or a file that cannot be written.
    """
    return write_page(page(certificate), path)


def page(certificate: Certificate) -> str:
    """Return the HTML text of a certificate."""
    status = certificate.status
    checks = "".join(_check(check) for check in certificate.checks)
    tables = "".join(_table(table) for table in certificate.tables)
    verdict = f"{badge(status, VERDICT[status])} {html.escape(certificate.verdict)}"
    body = f"""<p class="verdict">{verdict}</p>
<div class="top"><div>{facts_table(certificate.facts)}</div>
<div><img alt="shape of the part with its interfaces" src="{_picture(certificate.silhouette)}">
</div></div>
<h2>Checks</h2>
<table class="checks">
<tr><th></th><th>what</th><th>found</th><th>what it means and what to do</th></tr>
{checks}</table>
<div class="tables">{tables}</div>
"""
    heading = f"Certificate of part &lsquo;{html.escape(certificate.name)}&rsquo;"
    return document(f"Certificate of part {certificate.name}", heading, body)


def _check(check: Check) -> str:
    limit = f' <span class="advice">({html.escape(check.limit)})</span>' if check.limit else ""
    texts = [f"{text[0].upper()}{text[1:]}." for text in (check.sentence, check.remedy) if text]
    texts = [html.escape(text) for text in texts]
    if check.remedy:
        texts[-1] = f"<b>{texts[-1]}</b>"
    return (
        f"<tr><td>{badge(check.status, WORDS[check.status])}</td>"
        f"<td>{html.escape(check.topic)}</td><td>{html.escape(check.value)}{limit}</td>"
        f'<td class="advice">{" ".join(texts)}</td></tr>\n'
    )


def _table(table: Table) -> str:
    title = f"{table.title[0].upper()}{table.title[1:]}"
    remark = f'<p class="remark">{html.escape(table.remark)}</p>' if table.remark else ""
    return (
        f"<section><h2>{html.escape(title)}</h2>"
        f"{number_table(table.columns, table.shown(MOST_ROWS))}{remark}</section>\n"
    )


def _picture(shape: Silhouette) -> str:
    """Return a view of the part from front, above and right as a data address."""
    figure = Picture(figsize=(5.0, 3.2))
    with styled():
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="datalim")
        x, y, depth = _project(1e3 * shape.nodes)
        flat = np.column_stack([x, y])
        if len(shape.triangles):
            corners = np.asarray(shape.nodes)[shape.triangles]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
            # far triangles first; brightness from the angle of normal and light
            order = np.argsort(depth[shape.triangles].mean(axis=1))
            order = order[(normal @ _VIEW)[order] > 0.0]
            light = 0.45 + 0.55 * np.clip(normal[order] @ _LIGHT, 0.0, 1.0)
            colours = np.tile([0.80, 0.84, 0.90], (len(corners), 1))
            for k, (_, members) in enumerate(shape.interfaces):
                whole = np.isin(shape.triangles, members).all(axis=1)
                colours[whole] = to_rgb(_colour(k))
            faces = light[:, None] * colours[order]
            axes.add_collection(
                PolyCollection(
                    list(flat[shape.triangles[order]]), facecolors=faces, edgecolors=faces,
                    linewidths=0.2, rasterized=True,
                )
            )  # fmt: skip
        if len(shape.lines):
            axes.add_collection(LineCollection(list(flat[shape.lines]), colors=INK, linewidths=1.6))
            axes.plot(x, y, "o", color=INK, markersize=2.2)
        elif not len(shape.triangles):
            axes.plot(x, y, "o", color=MUTED, markersize=1.5)
        for k, (name, members) in enumerate(shape.interfaces):
            at = list(members)
            if not np.isin(shape.triangles, members).all(axis=1).any():
                axes.plot(x[at], y[at], "o", color=_colour(k), markersize=5.0)
            axes.annotate(
                name, (x[at].mean(), y[at].max()), xytext=(8, 8), textcoords="offset points",
                color=_colour(k), fontweight="bold",
                bbox={"boxstyle": "round,pad=0.15", "fc": PAPER, "ec": "none", "alpha": 0.8},
            )  # fmt: skip
        _axes_cross(axes, flat)
        axes.margins(0.14)
    return image_address(figure)


def _colour(k: int) -> str:
    """Return the colour of an interface."""
    return COLORS[1 + k % (len(COLORS) - 1)]


_VIEW = np.array([0.45, -0.75, 0.48]) / np.linalg.norm([0.45, -0.75, 0.48])
_LIGHT = np.array([0.2, -0.55, 0.8]) / np.linalg.norm([0.2, -0.55, 0.8])


def _project(points: Array) -> tuple[Array, Array, Array]:
    """Return coordinates on the page and the distance towards the eye; z is up."""
    right = np.cross([0.0, 0.0, 1.0], _VIEW)
    right /= np.linalg.norm(right)
    up = np.cross(_VIEW, right)
    return points @ right, points @ up, points @ _VIEW


def _axes_cross(axes: object, flat: Array) -> None:
    """Draw the directions x, y, z of the part frame in the lower left corner."""
    x, y, _ = _project(np.eye(3))
    for name, dx, dy in zip("xyz", x, y, strict=True):
        axes.annotate(  # type: ignore[attr-defined]
            "", (0.07 + 0.055 * dx, 0.12 + 0.086 * dy), xytext=(0.07, 0.12),
            xycoords="axes fraction", arrowprops={"arrowstyle": "-", "color": MUTED, "lw": 1.0},
        )  # fmt: skip
        axes.text(  # type: ignore[attr-defined]
            0.07 + 0.075 * dx, 0.12 + 0.117 * dy, name, transform=axes.transAxes,  # type: ignore[attr-defined]
            color=MUTED, ha="center", va="center", fontsize=8.5,
        )  # fmt: skip
