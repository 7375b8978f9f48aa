"""Report of hot spots: table and certificate as texts."""

from __future__ import annotations

import numpy as np

from jousto.recovery.hotspots.search_result import Found, HotSpot


def shown_value(value: float, unit: str) -> str:
    """Return a stress in MPa, or a strain in um/m, as a text."""
    return f"{value / 1e6:.6g} MPa" if unit == "Pa" else f"{1e6 * value:.6g} um/m"


def head(found: Found, several: bool) -> list[str]:
    """Return the header of the table."""
    unit = "MPa" if found.unit == "Pa" else "um/m"
    body = ["body"] if several else []
    names = [f"{found.criterion} ({unit})", "mesh", "between", "at (s)"]
    names += ["x (mm)", "y (mm)", "z (mm)", "plane normal"]
    return ["", *body, "site", *names]


def row(found: Found, spot: HotSpot, several: bool) -> list[str]:
    """Return the row of a hot spot in the table."""
    factor = 1e-6 if found.unit == "Pa" else 1e6
    body = [spot.body] if several else []
    place = [f"{1e3 * x:.5g}" for x in spot.position]
    normal = " ".join(f"{x:.3f}" for x in np.round(spot.normal, 3) + 0.0)
    value = f"{factor * spot.value:.6g}"
    gap = f"{factor * spot.between:.4g}" if np.isfinite(spot.between) else "-"
    mesh = f"+-{factor * spot.mesh:.2g}" if np.isfinite(spot.mesh) else "-"
    return [str(spot.rank), *body, spot.site, value, mesh, gap, f"{spot.time:.6g}", *place, normal]


def certificate_lines(found: Found) -> list[str]:
    """Return the lines of the certificate: the number of checked sites and the proved bounds."""
    lines = []
    for name, c in found.certificates.items():
        share = 100.0 * c.pruned / max(c.places, 1)
        total = float(c.places) * c.instants
        worked = c.knots + c.full
        few = f"; {worked:.3g} of {total:.3g} values computed" if worked < total else ""
        bounded = f", {c.pruned} ({share:.1f} %) by an upper bound over the run" if c.pruned else ""
        lines.append(
            f"'{name}': all {c.places} sites were checked at all {c.instants} stored instants"
            f"{bounded}{few}"
        )
        if c.pruned and np.isfinite(c.best_pruned):
            lines.append(f"  the largest bound of a pruned site is {_bound(found, c.best_pruned)}")
        if c.neighbours:
            lines.append(
                f"  {c.neighbours} sites are within {1e3 * c.separation:.4g} mm of a hot spot"
            )
    if not found.spots:
        return lines
    last = shown_value(found.spots[-1].value, found.unit)
    what = {
        "largest": "exceeds",
        "smallest": "falls below",
        "magnitude": "exceeds in magnitude",
    }[found.extreme]
    if not np.isfinite(found.bound):
        lines.append("no other site is left: all are hot spots or next to one")
    elif found.certified:
        lines.append(
            f"certified: no other site {what} {_bound(found, found.bound)} at any stored instant "
            f"from {found.start:g} to {found.end:g} s, of the listed sites; "
            f"the last of the list has {last}"
        )
    else:
        lines.append(f"not certified: other sites may reach {_bound(found, found.bound)}")
    return [*lines, _between(found), _mesh(found)]


def _mesh(found: Found) -> str:
    """Return the line that explains the column `+-` of the table, the error of the mesh."""
    if found.fields[0].strain:
        return "error of the mesh: not known for strain; use the stress"
    blind = [field.name for field in found.fields if field.modes.scatter is None]
    text = "error of the mesh (+-): difference between the elements around a site"
    if not blind:
        return text
    names = ", ".join(f"'{name}'" for name in blind)
    why = f"not known for {names}: the part has no mesh of solids, or was reduced without it"
    return f"error of the mesh: {why}" if len(blind) == len(found.fields) else f"{text}; {why}"


def _between(found: Found) -> str:
    """Return a line on the bound between the stored instants."""
    bound = found.bound_between
    if not np.isfinite(bound):
        return (
            "between the stored instants it is not known (no velocities are stored): store more "
            "instants (output_step)"
        )
    first = found._ranked(found.spots[0].value)
    more = f", {100.0 * (bound / first - 1.0):.2g} % above the first" if first > 0.0 else ""
    text = f"between the stored instants no site exceeds {_bound(found, bound)}{more}"
    if all(gap is None or gap.resolved for gap in found.gaps.values()):
        return f"{text}, by the stored velocities, for a motion that is smooth between them"
    return f"{text}; the instants are too far apart for the vibrations, store more (output_step)"


def _bound(found: Found, ranked: float) -> str:
    return shown_value(-ranked if found.extreme == "smallest" else ranked, found.unit)
