"""Sensors of flexible bodies: modal coordinates and stress."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Field, field
from jousto.base.numbers import set_fields
from jousto.base.voigt import STRESS_COMPONENTS
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.body_field import FlexibleField
from jousto.mechanism.sensors.base import Reading, Sensor


class ModalSensor(Sensor, tag="modal"):
    """Modal coordinates and velocities of a flexible body, (2n,): p then p'."""

    unit: ClassVar[str] = "kg^0.5 m, kg^0.5 m/s"
    frame: ClassVar[str] = "body"
    flexible: ClassVar[bool] = True
    body: FlexibleField = field("The body")

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components, p1..pn then p1'..pn'."""
        n = self.body.n
        p = tuple(f"p{j + 1}" for j in range(n))
        return p + tuple(f"{name}'" for name in p)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("modal", self.body)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"modal coordinates and velocities of {self.body.name}"


class DeformationMomentumSensor(Sensor, tag="deformation-momentum"):
    """Momenta of the deformation of a flexible body relative to its frame, (6,).

    ``int Phi p' dm`` in kg m/s and ``int (u0 + Phi p) x Phi p' dm`` in kg m2/s about the origin of
    the frame, both resolved in the body frame (Schwertassek, Wallrapp and Shabana 1999). In a
    Tisserand (mean-axis) frame the first is zero and the second is of the order of products of p
    and p'; in a nodal or chord frame both are of first order. The momenta measure how much the
    frame differs from a Tisserand frame.
    """

    unit: ClassVar[str] = "kg m/s, kg m2/s"
    frame: ClassVar[str] = "body"
    flexible: ClassVar[bool] = True
    components: ClassVar[tuple[str, ...]] = ("px", "py", "pz", "hx", "hy", "hz")
    body: FlexibleField = field("The body")

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("deformation momentum", self.body)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"momenta of the deformation of {self.body.name}"


class Sites(Field["Iterable[str] | str | None", "tuple[str, ...]"]):
    """Field of labels of stress sites; model files may contain positions."""

    form = "sites"
    noun = "sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the labels as a tuple, or report wrong ones."""
        if not isinstance(value, Iterable):
            problems.add(where, f"{self.name} is {value!r}, must be labels of stress sites")
            return ()
        return (value,) if isinstance(value, str) else tuple(value)


class SiteSensor(Sensor):
    """Base of all sensors of the stress at stress sites."""

    engine: ClassVar[str] = "stress"
    """Name of the kind in the engine."""
    quantity: ClassVar[str] = "stress"
    values: ClassVar[tuple[str, ...]] = STRESS_COMPONENTS
    unit: ClassVar[str] = "Pa"
    frame: ClassVar[str] = "element"
    flexible: ClassVar[bool] = True
    body: FlexibleField = field("Flexible body whose part has stress data")
    sites: Sites = field(
        'Labels of the stress sites, such as ``"e3.a.top"`` (in files also positions, for the '
        "nearest sites); None for all sites",
        default=None,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report unknown sites; None selects all sites."""
        body, labels = self.body, known_sites(where, self.body)
        given = vars(self)["sites"]
        wanted: tuple[Any, ...] = labels if given is None else given
        if not wanted:
            problems.add(where, "sites is empty; use None for all sites", "sites")
        elif all(isinstance(site, float | int) for site in wanted):
            problems.add(
                where,
                f"sites is {wanted!r}, must be labels such as {labels[0]!r}; the site nearest to "
                f"a point is {body.name}.reduced.stress.nearest((x, y, z))",
                "sites",
            )
        else:
            for site in wanted:
                check_site(problems, where, "sites", body, site)
        set_fields(self, sites=wanted)

    @property
    def indices(self) -> tuple[int, ...]:
        """Indices of the sites in ``body.reduced.stress``."""
        position = {label: i for i, label in enumerate(known_sites(self.name, self.body))}
        return tuple(position[site] for site in self.sites)

    @property
    def rows(self) -> Array:
        """Stress per unit modal coordinate, (6 ns, n) Pa: six components of each site."""
        stress = self.body.reduced.stress
        assert stress is not None
        return read_only(np.vstack([stress.modes[i] for i in self.indices]))

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components: ``site:s11`` and so on, or the sites only."""
        if len(self.values) == 1:
            return self.sites
        return tuple(f"{site}:{value}" for site in self.sites for value in self.values)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading(self.engine, self.body, rows=self.rows)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"{self.quantity} of {self.body.name}"


class StressSensor(SiteSensor, tag="stress"):
    """Stress at section points of a flexible body, (6 ns,) Pa.

    Six components [s11, s22, s33, s12, s23, s13] per site, site after site, in element axes.
    """


class VonMisesSensor(SiteSensor, tag="von-mises"):
    """Equivalent stress at sites of a flexible body, (ns,) Pa.

    ``sqrt(((s11-s22)^2 + (s22-s33)^2 + (s33-s11)^2) / 2 + 3 (s12^2 + s23^2 + s13^2))``
    """

    engine: ClassVar[str] = "von mises"
    quantity: ClassVar[str] = "von Mises stress"
    values: ClassVar[tuple[str, ...]] = ("mises",)


class PrincipalStressSensor(SiteSensor, tag="principal-stress"):
    """Principal stresses at sites of a flexible body, (3 ns,) Pa, the largest first."""

    engine: ClassVar[str] = "principal"
    quantity: ClassVar[str] = "principal stress"
    values: ClassVar[tuple[str, ...]] = ("max", "mid", "min")


def known_sites(where: str, body: FlexibleBody) -> tuple[str, ...]:
    """Return the labels of the stress sites of a body.

    Raises
    ------
    InputError
        If the part has no stress data.
    """
    stress: Any = getattr(body.reduced, "stress", None)
    if stress is None:
        raise InputError(
            Problem(
                where,
                f"body {body.name!r} has no stress modes; its part has no stress data",
                path=("body",),
            )
        )
    return tuple(stress.labels)


def check_site(problems: Problems, where: str, key: str, body: FlexibleBody, site: Any) -> None:
    """Report a problem unless a body has a stress site with the label."""
    labels = known_sites(where, body)
    if site not in labels:
        problems.add(
            where,
            f"body {body.name!r} has no stress site {site!r}{suggest(str(site), labels)}",
            key,
            named=False,
        )
