"""Sensors of flexible bodies: modal coordinates, stress and strain."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.errors import InputError, Problem, Problems, suggest
from jousto.mechanism.body import FlexibleBody
from jousto.mechanism.fields import check_name, number, set_fields
from jousto.mechanism.orientation import Array, readonly

VOIGT = ("s11", "s22", "s33", "s12", "s23", "s13")
LINE = 1e-6  # of the part's size: how far beside a line between two sites a gauge may lie


@dataclass(frozen=True, eq=False, init=False)
class ModalSensor:
    """Modal coordinates and velocities of a flexible body, (2n,): p then p'."""

    unit: ClassVar[str] = "kg^0.5 m, kg^0.5 m/s"
    frame: ClassVar[str] = "body"
    name: str
    body: FlexibleBody

    def __init__(self, name: str, body: FlexibleBody) -> None:
        problems = Problems()
        check_flexible(problems, check_name(problems, "sensor", name), body)
        problems.raise_if_any()
        set_fields(self, name=name, body=body)

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components, p1..pn then p1'..pn'."""
        n = self.body.n
        p = tuple(f"p{j + 1}" for j in range(n))
        return p + tuple(f"{name}'" for name in p)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"modal coordinates and velocities of {self.body.name}"


@dataclass(frozen=True, eq=False, init=False)
class SiteSensor:
    """What all sensors of the stress at named places have in common.

    Parameters
    ----------
    name : str
        Name, unique among the sensors.
    body : FlexibleBody
        A body whose part knows stresses.
    sites : sequence of str, optional
        Labels of the stress sites, such as ``"e3.a.top"``; None for all of them.
    """

    quantity: ClassVar[str] = "stress"
    values: ClassVar[tuple[str, ...]] = VOIGT
    unit: ClassVar[str] = "Pa"
    frame: ClassVar[str] = "element"
    name: str
    body: FlexibleBody
    sites: tuple[str, ...]

    def __init__(
        self, name: str, body: FlexibleBody, sites: Iterable[str] | str | None = None
    ) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        check_flexible(problems, where, body)
        problems.raise_if_any()
        labels = known_sites(where, body)
        wanted = labels if sites is None else (sites,) if isinstance(sites, str) else tuple(sites)
        if not wanted:
            problems.add(where, "sites is empty; None takes all of them")
        for site in wanted:
            check_site(problems, where, "sites", body, site)
        problems.raise_if_any()
        set_fields(self, name=name, body=body, sites=wanted)

    @property
    def indices(self) -> tuple[int, ...]:
        """Rows of the sites in ``body.reduced.stress``."""
        position = {label: i for i, label in enumerate(known_sites(self.name, self.body))}
        return tuple(position[site] for site in self.sites)

    @property
    def rows(self) -> Array:
        """Stress of each mode, (6 ns, n) Pa: six components of each site."""
        stress = self.body.reduced.stress
        assert stress is not None
        return readonly(np.vstack([stress.modes[i] for i in self.indices]))

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components, ``site:s11`` and so on, or the sites alone."""
        if len(self.values) == 1:
            return self.sites
        return tuple(f"{site}:{value}" for site in self.sites for value in self.values)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"{self.quantity} of {self.body.name}"


@dataclass(frozen=True, eq=False, init=False)
class StressSensor(SiteSensor):
    """Stress at section points of a flexible body, (6 ns,) Pa.

    Six components [s11, s22, s33, s12, s23, s13] of each site after each other, in the
    element's axes.
    """


@dataclass(frozen=True, eq=False, init=False)
class VonMisesSensor(SiteSensor):
    """Equivalent stress at sites of a flexible body, (ns,) Pa.

    ``sqrt(((s11-s22)^2 + (s22-s33)^2 + (s33-s11)^2) / 2 + 3 (s12^2 + s23^2 + s13^2))``
    """

    quantity: ClassVar[str] = "von Mises stress"
    values: ClassVar[tuple[str, ...]] = ("mises",)


@dataclass(frozen=True, eq=False, init=False)
class PrincipalStressSensor(SiteSensor):
    """Principal stresses at sites of a flexible body, (3 ns,) Pa, the largest first."""

    quantity: ClassVar[str] = "principal stress"
    values: ClassVar[tuple[str, ...]] = ("max", "mid", "min")


@dataclass(frozen=True, eq=False, init=False)
class StrainSensor:
    """Strain of a virtual strain gauge on a flexible body, (1,) m/m.

    ``e = t^T eps t`` along the direction t, with the strain ``eps = ((1 + nu) s - nu tr(s) 1) / E``
    of the stress s at the place: Hooke's law of an isotropic material.

    Parameters
    ----------
    name : str
        Name, unique among the sensors.
    body : FlexibleBody
        A body whose part knows stresses.
    place : str or (3,) array_like
        Label of a stress site such as ``"e3.a.top"``, or a position in the part frame, m, on a
        straight line between two sites of a beam element, where stress is linear.
    direction : (3,) array_like
        Along the gauge, in the axes of the element: (1, 0, 0) is along a beam.
    E, nu : float, optional
        Young's modulus, Pa, and Poisson's ratio, for parts that do not know them. Parts made of
        beams do.
    """

    unit: ClassVar[str] = "m/m"
    frame: ClassVar[str] = "element"
    components: ClassVar[tuple[str, ...]] = ("e",)
    name: str
    body: FlexibleBody
    place: str | Array
    direction: Array
    E: float
    nu: float

    def __init__(
        self,
        name: str,
        body: FlexibleBody,
        place: str | ArrayLike,
        direction: ArrayLike = (1.0, 0.0, 0.0),
        *,
        E: float | None = None,
        nu: float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        check_flexible(problems, where, body)
        problems.raise_if_any()
        known_sites(where, body)
        at: Any = place
        if isinstance(place, str):
            check_site(problems, where, "place", body, place)
        else:
            at = problems.array(where, "place", place, (3,))
        t = problems.array(where, "direction", direction, (3,))
        if t is not None and not np.any(t):
            problems.add(where, "direction is zero")
        problems.raise_if_any()
        weights = site_weights(where, body, at)
        young, poisson = elasticity(where, body, next(iter(weights)), E, nu)
        set_fields(
            self,
            name=name,
            body=body,
            place=at,
            direction=readonly(np.asarray(t) / np.linalg.norm(np.asarray(t))),
            E=young,
            nu=poisson,
        )

    @property
    def rows(self) -> Array:
        """Strain of each mode, (1, n)."""
        stress = self.body.reduced.stress
        assert stress is not None
        x, y, z = self.direction
        along = np.array([x * x, y * y, z * z, 2 * x * y, 2 * y * z, 2 * x * z])
        trace = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        gauge = ((1.0 + self.nu) * along - self.nu * trace) / self.E
        weights = site_weights(f"sensor {self.name!r}", self.body, self.place)
        modes = np.sum([w * stress.modes[i] for i, w in weights.items()], axis=0)
        return readonly((gauge @ modes)[None])

    @property
    def description(self) -> str:
        """One line for results and plots."""
        place = self.place
        at = place if isinstance(place, str) else "(" + ", ".join(f"{x:g}" for x in place) + ")"
        along = ", ".join(f"{x:.4g}" for x in self.direction)
        return f"strain of {self.body.name} at {at} along ({along})"


def check_flexible(problems: Problems, where: str, body: Any) -> None:
    """Note a problem unless `body` is a flexible body."""
    if not isinstance(body, FlexibleBody):
        problems.add(where, f"body is {body!r}, must be a flexible body")


def known_sites(where: str, body: FlexibleBody) -> tuple[str, ...]:
    """Return the labels of the stress sites of a body.

    Raises
    ------
    InputError
        If its part knows no stress.
    """
    stress: Any = getattr(body.reduced, "stress", None)
    if stress is None:
        raise InputError(
            Problem(where, f"body {body.name!r} has no stress modes; its part knows no stress")
        )
    return tuple(stress.labels)


def check_site(problems: Problems, where: str, key: str, body: FlexibleBody, site: Any) -> None:
    """Note a problem unless a body has a stress site of that label."""
    labels = known_sites(where, body)
    if site not in labels:
        problems.add(
            where,
            f"{key}: body {body.name!r} has no stress site {site!r}{suggest(str(site), labels)}",
        )


def site_weights(where: str, body: FlexibleBody, place: str | Array) -> dict[int, float]:
    """Return the stress sites, by index, of which the stress at a place is a linear combination.

    Raises
    ------
    InputError
        If a position is not on a line between corresponding sites of an element's two ends.
    """
    stress = body.reduced.stress
    assert stress is not None
    labels = list(stress.labels)
    if isinstance(place, str):
        return {labels.index(place): 1.0}
    size = float(np.ptp(stress.positions, axis=0).max()) or 1.0
    best, least = "", np.inf
    for i, label in enumerate(labels):
        element, _, point = label.partition(".a.")
        other = f"{element}.b.{point}"
        if not point or other not in labels:
            continue
        j = labels.index(other)
        x, along = stress.positions[i], stress.positions[j] - stress.positions[i]
        s = float(np.clip(along @ (place - x) / (along @ along), 0.0, 1.0))
        distance = float(np.linalg.norm(x + s * along - place))
        if distance <= LINE * size:
            return {i: 1.0 - s, j: s}
        if distance < least:
            best, least = f"{label} and {other}", distance
    nearest = f"; the line nearest to it is that between {best}, {1e3 * least:.4g} mm away"
    raise InputError(
        Problem(
            where,
            f"place: {np.array2string(place, separator=', ')} m is on no line between stress sites "
            f"of body {body.name!r}{nearest if best else ''}; name a site",
        )
    )


def elasticity(
    where: str, body: FlexibleBody, site: int, E: float | None, nu: float | None
) -> tuple[float, float]:
    """Return Young's modulus and Poisson's ratio at a site, given or of the part.

    Raises
    ------
    InputError
        If neither is known, or a given one is out of range.
    """
    problems = Problems()
    stress = body.reduced.stress
    known = None if stress is None else stress.elasticity
    values: list[float] = []
    for i, (key, value) in enumerate((("E", E), ("nu", nu))):
        if value is not None:
            found = number(problems, where, key, value)
            if found is not None and key == "E" and found <= 0.0:
                problems.add(where, f"E is {found:g} Pa, must be positive")
            if found is not None and key == "nu" and not -1.0 < found <= 0.5:
                problems.add(where, f"nu is {found:g}, must be in (-1, 0.5]")
            values.append(0.0 if found is None else found)
        elif known is not None:
            values.append(float(known[site, i]))
        else:
            problems.add(
                where, f"{key} is missing: the part of body {body.name!r} does not know it"
            )
    problems.raise_if_any()
    return values[0], values[1]
