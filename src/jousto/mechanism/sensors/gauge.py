"""Virtual strain gauges: strain at a position of a part, averaged over a grid."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Field, OptionalItem, Reference, field
from jousto.base.numbers import Number, OptionalNumber, set_fields
from jousto.base.rotations import Direction, unit_vector
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.temperature import Temperature
from jousto.mechanism.signals.base import Signal

if TYPE_CHECKING:
    from jousto.reduction.fields.beam_surface_strain import Element, Fibre
    from jousto.reduction.fields.stress import StressModes
    from jousto.reduction.reduced import ReducedPart

NU_CALIBRATION = 0.285
"""Poisson's ratio of the beam on which strain gauges are calibrated."""

REACH = 0.01
"""Largest distance of a gauge from the surface / size of the solid or beam section."""

LEAVES = 1e-6
"""Largest part of a grid beyond the end of a beam / length of the grid."""

TRACE = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


class Carrier(Reference["FlexibleBody | ReducedPart", "FlexibleBody | ReducedPart"]):
    """Field of a flexible body or reduced part; a model file contains the name of a body."""

    section = "bodies"
    word = "body"
    noun = "FlexibleBody or ReducedPart"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the body or part, or report that the value is neither."""
        if not isinstance(value, FlexibleBody) and not hasattr(value, "modes"):
            problems.add(
                where, f"{self.name} is {value!r}, must be a flexible body or a reduced part"
            )
        return value


class Spot(Field[str | ArrayLike, str | Array]):
    """Field of a position, or of the label of a stress site."""

    form = "spot"
    noun = "str or (3,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the label or the position, or report its problems."""
        return value if isinstance(value, str) else problems.array(where, self.name, value, (3,))


class Heading(Direction):
    """Field of a direction, stored as a unit vector."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the unit vector (3,), or report what is wrong."""
        found = problems.array(where, self.name, value, (3,))
        if found is not None and not found.any():
            problems.add(where, f"{self.name} is zero")
            return None
        return None if found is None else read_only(unit_vector(found))


class Attached(Sensor):
    """Base of all sensors of strain."""

    unit: ClassVar[str] = "m/m"
    frame: ClassVar[str] = "gauge"
    flexible: ClassVar[bool] = True
    body: Carrier = field(
        "Body or part on which the gauge is placed; sensors of a mechanism need a body"
    )
    at: Spot = field(
        "Position in the part frame, m, moved to the nearest point of the surface; or the label"
        ' of a stress site such as ``"e3.a.top"`` or ``"n12"``'
    )
    direction: Heading = field(
        "Direction of the gauge (of grid a of a rosette), part frame; on solids it is required "
        "and projected onto the tangent plane; None is along the beam",
        default=None,
    )
    length: Number = field(
        "Length of the grid over which strain is averaged; zero for a point",
        unit="m",
        least=0,
        default=0.0,
        kw_only=True,
    )
    width: Number = field("Width of the grid", unit="m", least=0, default=0.0, kw_only=True)
    transverse: Number = field(
        "Transverse sensitivity K, such as 0.005",
        above=-0.5,
        below=0.5,
        wanted="a share such as 0.005",
        default=0.0,
        kw_only=True,
    )
    temperature: OptionalItem[Temperature] = field(
        "Temperature change that causes apparent strain",
        wanted="a Temperature(signal, part=..., gauge=...)",
        default=None,
        kw_only=True,
    )
    reach: OptionalNumber = field(
        "Largest distance of the position from the surface; None for 1 % of the size of the part "
        "(solids) or of the section (beams)",
        unit="m",
        least=0,
        default=None,
        kw_only=True,
    )
    E: OptionalNumber = field(
        "Young's modulus, for parts without material data",
        unit="Pa",
        above=0,
        default=None,
        kw_only=True,
    )
    nu: OptionalNumber = field(
        "Poisson's ratio, for parts without material data",
        above=-1,
        most=0.5,
        wanted="in (-1, 0.5]",
        default=None,
        kw_only=True,
    )


class Gauge(Attached, tag="gauge"):
    """Virtual strain gauge on a flexible body, (1,) m/m.

    On solids its value is the mean strain of the surface under the grid, from the displacements of
    the modes: ``e = sum c . du / sum |dx|`` along the grid, exact for the finite element field. On
    beams it is ``e = t . eps t`` with Hooke's ``eps = ((1 + nu) s - nu tr(s) 1) / E`` where s is
    the stress of the section, which is linear along an element. A gauge may be at any position
    along the element; a gauge in the direction of the beam also at any point of the section.

    With the transverse sensitivity K a gauge calibrated at Poisson's ratio 0.285 indicates
    ``(e + K e_across) / (1 - 0.285 K)`` (ASTM E251).

    Attributes
    ----------
    position : (3,) array
        Position of the gauge, part frame, m.
    axis : (3,) array
        Unit vector along the grid, part frame.
    rows : (1, n) array
        Strain per unit modal coordinate, kg^-0.5/m.

    Raises
    ------
    InputError
        With all problems: a position off the surface, a grid that leaves the surface, a direction
        normal to the surface, a part with only the stress along the beam for a gauge that needs
        shear.
    """

    kind = "gauge"
    components: ClassVar[tuple[str, ...]] = ("e",)

    def consistent(self, problems: Problems, where: str) -> None:
        """Place the gauge on its part: position, axis and rows."""
        position, axis, rows = self.placed(self.reduced)
        found = {"position": position, "axis": axis, "rows": rows[None]}
        set_fields(self, **{key: read_only(value) for key, value in found.items()})

    if TYPE_CHECKING:

        @property
        def position(self) -> Array: ...  # noqa: D102
        @property
        def axis(self) -> Array: ...  # noqa: D102
        @property
        def rows(self) -> Array: ...  # noqa: D102

    @property
    def reduced(self) -> ReducedPart:
        """Part on which the gauge is placed."""
        return self.body.reduced if isinstance(self.body, FlexibleBody) else self.body

    @property
    def signal(self) -> Signal | None:
        """Apparent strain as a function of time."""
        return None if self.temperature is None else self.temperature.apparent

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("stress", self.body, self.signal, rows=self.rows)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        at = ", ".join(f"{x:.5g}" for x in self.position)
        along = ", ".join(f"{x:.4g}" for x in self.axis + 0.0)
        return f"strain of {self.body.name} at ({at}) along ({along})"

    def placed(self, reduced: ReducedPart) -> tuple[Array, Array, Array]:
        """Return position (3,), axis (3,) and rows (n,) of the gauge on a part.

        Raises
        ------
        InputError
            If the gauge does not fit the part.
        """
        where = f"gauge {self.name!r}"
        if isinstance(self.at, str):
            stress = known_stress(where, reduced)
            if self.at not in stress.labels:
                raise InputError(
                    Problem(
                        where,
                        f"part '{reduced.name}' has no stress site {self.at!r}"
                        f"{suggest(self.at, stress.labels)}",
                        path=("at",),
                        named=False,
                    )
                )
        if reduced.faces:
            return _on_surface(self, where, reduced)
        return _on_beam(self, where, reduced)


@explained
def gauge_rows(gauges: Iterable[Any], reduced: ReducedPart | None = None) -> Array:
    """Return B (ng, n) of ``e = B p``: the outputs of gauges per unit modal coordinate.

    Parameters
    ----------
    gauges : iterable of Gauge, Rosette or Bridge
        A gauge has one row, m/m; a rosette one per grid, m/m; a bridge one, V/V.
    reduced : ReducedPart, optional
        Part on which the gauges are placed, such as the same part with more modes; None for the
        parts of the gauges.

    Raises
    ------
    InputError
        If gauges do not fit the part, or belong to different parts.

    Examples
    --------
    ``gauge_rows([g1, g2])`` for gauges on one body.
    """
    items = list(gauges)
    problems = Problems()
    if not items:
        problems.add("gauges", "the list is empty; give at least one Gauge")
    blocks = []
    for i, item in enumerate(items):
        if not hasattr(item, "placed") or not hasattr(item, "rows"):
            problems.add(f"gauges[{i}]", f"is {item!r}, must be a Gauge, Rosette or Bridge")
            continue
        try:
            blocks.append(item.rows if reduced is None else np.atleast_2d(item.placed(reduced)[2]))
        except InputError as error:
            problems.found += error.problems
    problems.raise_if_any()
    counts = {block.shape[1] for block in blocks}
    if len(counts) > 1:
        names = ", ".join(f"{g.name!r} on '{g.reduced.name}'" for g in items[:4])
        raise InputError(
            Problem("gauges", f"they belong to parts with different numbers of modes: {names}")
        )
    return np.concatenate(blocks)


def outward(g: Gauge, given: Array | None = None) -> Array:
    """Return the outward unit normal (3,) of the surface at a gauge, part frame.

    Parameters
    ----------
    g : Gauge
    given : (3,) array, optional
        Normal on a beam, if it does not point away from the middle of the section.
    """
    if g.reduced.faces:
        from jousto.reduction.fields.solid_surface_strain import Skin

        feet = Skin(g.reduced.nodes, g.reduced.faces).feet(g.position)
        n = np.mean([foot.normal for foot in feet], axis=0)
        return np.asarray(n / np.linalg.norm(n))
    from jousto.reduction.fields.beam_surface_strain import elements, nearest_fibre

    where = f"gauge {g.name!r}"
    stress = known_stress(where, g.reduced)
    beams = elements(stress)
    if given is None and not beams:
        raise InputError(
            Problem(
                where,
                "normal is missing; give it, since the part has neither a surface nor beams",
                path=("normal",),
            )
        )
    if given is not None:
        along = g.axis
        n = given - (given @ along) * along
    else:
        fibre = nearest_fibre(beams, g.position)
        e = fibre.element
        y, z = fibre.shares @ e.yz - 0.5 * (e.yz.min(axis=0) + e.yz.max(axis=0))
        n = e.axes[:, 1:] @ np.array([y, z])
    if np.linalg.norm(n) <= 1e-9:
        raise InputError(
            Problem(
                where,
                "normal is missing or along the gauge; give normal=...",
                path=("normal",),
            )
        )
    return np.asarray(n / np.linalg.norm(n))


def known_stress(where: str, reduced: ReducedPart) -> StressModes:
    """Return the stress modes of a part.

    Raises
    ------
    InputError
        If the part has no stress data.
    """
    if reduced.stress is None:
        raise InputError(
            Problem(
                where,
                f"part '{reduced.name}' has no stress modes and no surface; gauges need a part of "
                "beams with section points or of solids",
                path=("part",),
            )
        )
    return reduced.stress


def _across(e: Array, across: Array | float, K: float) -> Array:
    """Return the strain (n,) that a gauge with transverse sensitivity K indicates."""
    return np.asarray((e + K * across) / (1.0 - NU_CALIBRATION * K))


# -- solids -----------------------------------------------------------------------------------


def _on_surface(g: Gauge, where: str, reduced: ReducedPart) -> tuple[Array, Array, Array]:
    from jousto.reduction.fields.solid_surface_strain import (
        LeavesSurface,
        Skin,
        grid_strain,
        point_strain,
        tangent,
    )

    x = g.at
    if isinstance(x, str):
        stress = known_stress(where, reduced)
        x = stress.positions[stress.labels.index(x)]
    problems = Problems()
    skin = Skin(reduced.nodes, reduced.faces)
    used = np.unique(np.concatenate([face.ravel() for face in reduced.faces]))
    size = float(np.ptp(reduced.nodes[used], axis=0).max())
    feet = skin.feet(x)
    foot = feet[0]
    reach = REACH * size if g.reach is None else g.reach
    if foot.distance > max(reach, 1e-9 * size):
        near = ", ".join(f"{v:.5g}" for v in foot.x.round(9) + 0.0)
        problems.add(
            where,
            f"is {1e3 * foot.distance:.4g} mm off the surface of part '{reduced.name}', more "
            f"than reach {1e3 * reach:.4g} mm; the nearest point of the surface is ({near}) m",
            "at",
            named=False,
        )
    if g.direction is None:
        problems.add(
            where, "direction is missing; give it, solids have no default direction", "direction"
        )
        problems.raise_if_any()
    assert g.direction is not None
    normal = np.mean([f.normal for f in feet], axis=0)
    normal /= np.linalg.norm(normal)
    if 1.0 - abs(float(g.direction @ normal)) < 1e-4:
        problems.add(
            where,
            "direction is normal to the surface, whose normal there is "
            f"({', '.join(f'{v:.3g}' for v in normal.round(6) + 0.0)}); give a direction along "
            f"the surface",
            "direction",
        )
    problems.raise_if_any()
    t = tangent(g.direction, normal)
    u = reduced.modes
    if g.length == 0.0 and g.width == 0.0:
        e = point_strain(feet, t)(u)
        if g.transverse:
            e = _across(e, point_strain(feet, np.cross(normal, t))(u), g.transverse)
        return foot.x, t, e
    # a grid without a length is as long as it is wide
    length, width = g.length or g.width, g.width
    try:
        e = grid_strain(skin, foot, tangent(t, foot.normal), length, width)(u)
        if g.transverse:
            across = np.cross(foot.normal, t)
            e = _across(
                e, grid_strain(skin, foot, across, width or length, length)(u), g.transverse
            )
    except LeavesSurface as error:
        raise InputError(
            Problem(
                where,
                f"its grid of {1e3 * length:.4g} x {1e3 * width:.4g} mm leaves the surface or "
                f"crosses an edge {1e3 * error.reach:.3g} mm from its middle; move or shorten it",
            )
        ) from error
    return foot.x, t, e


# -- beams ------------------------------------------------------------------------------------


def _on_beam(g: Gauge, where: str, reduced: ReducedPart) -> tuple[Array, Array, Array]:
    from jousto.reduction.fields.beam_surface_strain import elements, nearest_fibre

    stress = known_stress(where, reduced)
    beams = elements(stress)
    if isinstance(g.at, str):
        i = stress.labels.index(g.at)
        x, axes = stress.positions[i], stress.axes[i]
        if g.length == 0.0 or not beams:
            t = axes[:, 0] if g.direction is None else g.direction
            site = {i: 1.0}
            return x, t, _hooke(g, where, reduced, stress, axes.T @ t, site)
        point = x
    else:
        point = g.at
        if not beams:
            raise InputError(
                Problem(
                    where,
                    f"part '{reduced.name}' has neither a surface nor beams; name a stress "
                    f"site such as {stress.nearest(point)!r}",
                    path=("at",),
                    named=False,
                )
            )
    fibre = nearest_fibre(beams, point)
    element = fibre.element
    reach = REACH * element.size if g.reach is None else g.reach
    if fibre.distance > max(reach, 1e-9 * element.length):
        near = ", ".join(f"{v:.5g}" for v in fibre.x)
        raise InputError(
            Problem(
                where,
                f"is {1e3 * fibre.distance:.4g} mm off the beams of part '{reduced.name}', "
                f"more than reach {1e3 * reach:.4g} mm; the nearest point is ({near}) m on element "
                f"{element.name}",
                path=("at",),
                named=False,
            )
        )
    t = element.axes[:, 0] if g.direction is None else g.direction
    local = element.axes.T @ t
    if not fibre.exact and max(abs(local[0] * local[1]), abs(local[0] * local[2])) > 1e-9:
        raise InputError(
            Problem(
                where,
                "measures shear, which is available at the section points of the beam only "
                f"({', '.join(element.points)}); place it on one of their lines or along the beam",
            )
        )
    sides = g.length * float(np.linalg.norm(local[1:]))
    if 0.0 < element.size * (1.0 + LEAVES) < sides:
        raise InputError(
            _off_beam(g, where, reduced, f"the section is {1e3 * element.size:.4g} mm")
        )
    shares = _along(fibre, beams, g.length * abs(float(local[0])))
    outside = 1.0 - sum(share for share, _ in shares)
    if outside > LEAVES:
        raise InputError(
            _off_beam(
                g,
                where,
                reduced,
                f"{100.0 * outside:.3g} % of its length lie beyond an end, a bend or a step of "
                f"the section",
            )
        )
    sites: dict[int, float] = {}
    for share, at in shares:
        for i, w in at.items():
            sites[i] = sites.get(i, 0.0) + share * w / (1.0 - outside)
    return fibre.x, t, _hooke(g, where, reduced, stress, local, sites)


def _off_beam(g: Gauge, where: str, reduced: ReducedPart, why: str) -> Problem:
    hint = ""
    if g.length > 0.1:  # no gauge is that long; 3 is probably 3 mm
        hint = f"; lengths are in m: if {g.length:g} mm are meant, give {1e-3 * g.length:g}"
    return Problem(
        where,
        f"its grid of {1e3 * g.length:.4g} mm leaves the beam of part '{reduced.name}': {why}; "
        f"move or shorten it{hint}",
    )


def _along(
    fibre: Fibre, beams: list[Element], length: float
) -> list[tuple[float, dict[int, float]]]:
    """Return sites and weights of the mean stress over a length of the fibre, element by element.

    The sum of the weights is less than one if part of the length extends beyond the beams.
    """
    from jousto.reduction.fields.beam_surface_strain import nearest_fibre

    if length == 0.0:
        return [(1.0, fibre.sites())]
    axis = fibre.element.axes[:, 0]
    size = max(fibre.element.size, 1e-300)
    cuts = {-0.5 * length, 0.5 * length}
    for e in beams:
        for end in (0.0, e.length):
            at = float((e.origin + end * e.axes[:, 0] - fibre.x) @ axis)
            if abs(at) < 0.5 * length:
                cuts.add(at)
    out = []
    edges = sorted(cuts)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        if b - a > 1e-9 * length:
            middle = fibre.x + 0.5 * (a + b) * axis
            there = nearest_fibre(beams, middle)
            near = there.distance <= 0.05 * size + 1e-9 * length
            if near and not _past_free_end(there, middle, beams):
                out.append(((b - a) / length, there.sites()))
    return out


def _past_free_end(there: Fibre, x: Array, beams: list[Element]) -> bool:
    """Return whether x (3,) lies beyond an end of an element to which no element is connected."""
    e = there.element
    along = float((x - e.origin) @ e.axes[:, 0])
    if -LEAVES * e.length <= along <= (1.0 + LEAVES) * e.length:
        return False
    end = e.origin + (0.0 if along < 0.0 else e.length) * e.axes[:, 0]
    others = [b.origin + s * b.axes[:, 0] for b in beams if b is not e for s in (0.0, b.length)]
    return not any(np.linalg.norm(other - end) <= 0.5 * e.size for other in others)


def _hooke(
    g: Gauge,
    where: str,
    reduced: ReducedPart,
    stress: StressModes,
    t: Array,
    sites: dict[int, float],
) -> Array:
    """Return the strain (n,) along t by Hooke's law from the mean stress of sites, site axes."""
    problems = Problems()
    first = next(iter(sites))
    values = []
    for column, (key, value) in enumerate((("E", g.E), ("nu", g.nu))):
        if value is not None:
            values.append(value)
        elif stress.elasticity is not None:
            values.append(float(stress.elasticity[first, column]))
        else:
            problems.add(
                where, f"{key} is missing; give it, part '{reduced.name}' has no material data"
            )
    problems.raise_if_any()
    E, nu = values
    mean = np.sum([w * stress.modes[i] for i, w in sites.items()], axis=0)

    def along(d: Array) -> Array:
        x, y, z = d
        square = np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z])
        return np.asarray((((1.0 + nu) * square - nu * TRACE) / E) @ mean)

    e = along(t)
    if g.transverse:
        # normal strain across the fibre, on a surface with axial stress and shear only: trace minus
        # the strain along the fibre
        trace = (1.0 - 2.0 * nu) / E * (TRACE @ mean)
        normal = -nu / E * (TRACE @ mean)
        e = _across(e, trace - normal - e, g.transverse)
    return e
