"""The certificate of a part as one HTML page: no network, no script, fit for printing."""

from __future__ import annotations

import base64
import html
import io
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.files import written
from jousto.certificate.certificate import Certificate, Check, Silhouette, Table
from jousto.output.style import COLORS, FAINT, INK, MUTED, PAPER, Picture, styled, target

WORDS = {"ok": "ok", "note": "note", "warn": "warning", "fail": "fault"}
COLOUR = {"ok": "#2A7D5F", "note": "#1C5FA8", "warn": "#A56A00", "fail": "#B3261E"}
MOST_ROWS = 24  # of a table
VERDICT = {
    "ok": "sound",
    "warn": "usable, read the warnings",
    "fail": "not to be trusted before the faults are repaired",
}

CSS = f"""
body {{ font: 13px/1.45 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; color: {INK};
       background: {PAPER}; max-width: 1080px; margin: 24px auto; padding: 0 20px; }}
h1 {{ font-size: 21px; margin: 0; }} h2 {{ font-size: 14px; margin: 20px 0 6px; }}
.verdict {{ margin: 4px 0 14px; }} .badge {{ color: {PAPER}; border-radius: 4px; padding: 1px 8px;
       font-weight: 600; white-space: nowrap; }}
.top {{ display: flex; gap: 28px; align-items: center; flex-wrap: wrap; }}
.top > * {{ flex: 1 1 380px; min-width: 0; }} img {{ max-width: 100%; height: auto; }}
table {{ border-collapse: collapse; width: 100%; }}
td, th {{ padding: 3px 10px 3px 0; text-align: left; vertical-align: top; }}
tr + tr td {{ border-top: 1px solid {FAINT}; }}
th {{ color: {MUTED}; font-weight: 500; border-bottom: 1px solid #9AA1AB; }}
.numbers td + td, .numbers th + th {{ text-align: right; font-variant-numeric: tabular-nums; }}
.numbers td {{ white-space: nowrap; }}
.name {{ color: {MUTED}; white-space: nowrap; }} .advice {{ color: {MUTED}; }}
.advice b {{ color: {INK}; font-weight: 600; }} .scroll {{ overflow-x: auto; }}
.checks td:nth-child(2) {{ white-space: nowrap; }} .checks td:nth-child(3) {{ width: 42%; }}
.tables {{ columns: 2 440px; column-gap: 32px; }} section {{ break-inside: avoid; }}
section h2 {{ padding-top: 14px; margin-top: 0; }}
.remark, footer {{ color: {MUTED}; font-size: 11.5px; }} footer {{ margin-top: 22px; }}
@media print {{ body {{ font-size: 8.6px; margin: 0; max-width: none; padding: 0; }}
       h1 {{ font-size: 15px; }} h2 {{ font-size: 10.5px; margin: 7px 0 2px; }}
       td, th {{ padding: 1px 6px 1px 0; line-height: 1.25; }} .verdict {{ margin: 2px 0 6px; }}
       .top {{ flex-wrap: nowrap; gap: 12px; }} .top > * {{ flex: 1 1 45%; }}
       img {{ max-height: 44mm; }}
       .tables {{ columns: 2 auto; column-gap: 20px; }} section h2 {{ padding-top: 6px; }}
       .remark, footer {{ font-size: 7.6px; margin: 2px 0; }} }}
"""


@explained_as("write")
def write_certificate(certificate: Certificate, path: str | Path) -> Path:
    """Write a certificate as an HTML page that stands for itself: no network, no script.

    Parameters
    ----------
    certificate : Certificate
        From `certify`.
    path : str or Path
        File that ends in ``.html``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        Another ending, a folder that does not exist, or a file that cannot be written.
    """
    path = target(path, ("html", "htm"), hint="; print it to PDF in a browser")
    with written(path) as beside:
        beside.write_text(page(certificate), encoding="utf-8")
    return path


def page(certificate: Certificate) -> str:
    """Return the HTML text of a certificate."""
    name, status = html.escape(certificate.name), certificate.status
    facts = "".join(
        f'<tr><td class="name">{html.escape(key)}</td><td>{html.escape(value)}</td></tr>'
        for key, value in certificate.facts
    )
    checks = "".join(_check(check) for check in certificate.checks)
    tables = "".join(_table(table) for table in certificate.tables)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Certificate of part {name}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{CSS}</style>
</head><body>
<h1>Certificate of part &lsquo;{name}&rsquo;</h1>
<p class="verdict">{_badge(status, VERDICT[status])} {html.escape(certificate.verdict)}</p>
<div class="top"><div><table>{facts}</table></div>
<div><img alt="shape of the part with its interfaces" src="{_picture(certificate.silhouette)}">
</div></div>
<h2>Checks</h2>
<table class="checks">
<tr><th></th><th>what</th><th>found</th><th>what it means and what to do</th></tr>
{checks}</table>
<div class="tables">{tables}</div>
<footer>Written by jousto {html.escape(_version())}.</footer>
</body></html>
"""


def _badge(status: str, text: str) -> str:
    return f'<span class="badge" style="background:{COLOUR[status]}">{html.escape(text)}</span>'


def _check(check: Check) -> str:
    limit = f' <span class="advice">({html.escape(check.limit)})</span>' if check.limit else ""
    texts = [f"{text[0].upper()}{text[1:]}." for text in (check.sentence, check.remedy) if text]
    texts = [html.escape(text) for text in texts]
    if check.remedy:
        texts[-1] = f"<b>{texts[-1]}</b>"
    return (
        f"<tr><td>{_badge(check.status, WORDS[check.status])}</td>"
        f"<td>{html.escape(check.topic)}</td><td>{html.escape(check.value)}{limit}</td>"
        f'<td class="advice">{" ".join(texts)}</td></tr>\n'
    )


def _table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(name)}</th>" for name in table.columns)
    rows = "".join(
        f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>\n"
        for row in table.shown(MOST_ROWS)
    )
    title = f"{table.title[0].upper()}{table.title[1:]}"
    remark = f'<p class="remark">{html.escape(table.remark)}</p>' if table.remark else ""
    return (
        f'<section><h2>{html.escape(title)}</h2><div class="scroll"><table class="numbers">'
        f"<tr>{head}</tr>\n{rows}</table></div>{remark}</section>\n"
    )


def _picture(shape: Silhouette) -> str:
    """Return the part seen from the front, above and to the right, as a data address."""
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
            # far triangles first; outward normals towards the light are bright
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
        data = io.BytesIO()
        figure.savefig(data, format="png", dpi=150)
    return "data:image/png;base64," + base64.b64encode(data.getvalue()).decode()


def _colour(k: int) -> str:
    """Return the colour of an interface."""
    return COLORS[1 + k % (len(COLORS) - 1)]


_VIEW = np.array([0.45, -0.75, 0.48]) / np.linalg.norm([0.45, -0.75, 0.48])
_LIGHT = np.array([0.2, -0.55, 0.8]) / np.linalg.norm([0.2, -0.55, 0.8])


def _project(points: Array) -> tuple[Array, Array, Array]:
    """Return points on the page and their distance towards the eye; z is up."""
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


def _version() -> str:
    from jousto.base.version import __version__

    return __version__
