"""Sensors of flexible bodies: modal coordinates and stress."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from jousto.base.arguments import explained
from jousto.base.described import described
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array, readonly
from jousto.mechanism.bodies.body import FlexibleBody

VOIGT = ("s11", "s22", "s33", "s12", "s23", "s13")


@described
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


@explained
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
        if wanted and all(isinstance(site, float | int) for site in wanted):
            problems.add(
                where,
                f"sites is {sites!r}, must be labels such as {labels[0]!r}; that of the place "
                f"nearest to a point is {body.name}.reduced.stress.nearest((x, y, z))",
            )
            problems.raise_if_any()
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


@described
@dataclass(frozen=True, eq=False, init=False)
class StressSensor(SiteSensor):
    """Stress at section points of a flexible body, (6 ns,) Pa.

    Six components [s11, s22, s33, s12, s23, s13] of each site after each other, in the
    element's axes.
    """


@described
@dataclass(frozen=True, eq=False, init=False)
class VonMisesSensor(SiteSensor):
    """Equivalent stress at sites of a flexible body, (ns,) Pa.

    ``sqrt(((s11-s22)^2 + (s22-s33)^2 + (s33-s11)^2) / 2 + 3 (s12^2 + s23^2 + s13^2))``
    """

    quantity: ClassVar[str] = "von Mises stress"
    values: ClassVar[tuple[str, ...]] = ("mises",)


@described
@dataclass(frozen=True, eq=False, init=False)
class PrincipalStressSensor(SiteSensor):
    """Principal stresses at sites of a flexible body, (3 ns,) Pa, the largest first."""

    quantity: ClassVar[str] = "principal stress"
    values: ClassVar[tuple[str, ...]] = ("max", "mid", "min")


def check_flexible(problems: Problems, where: str, body: Any) -> None:
    """Note a problem unless `body` is a flexible body."""
    if not isinstance(body, FlexibleBody):
        problems.add(where, f"body is {body!r}, must be a flexible body")


def known_sites(where: str, body: FlexibleBody) -> tuple[str, ...]:
    """Return the labels of the stress sites of a body.

    Raises
    ------
    InputError
        If its part has no stress data.
    """
    stress: Any = getattr(body.reduced, "stress", None)
    if stress is None:
        raise InputError(
            Problem(where, f"body {body.name!r} has no stress modes; its part has no stress data")
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
