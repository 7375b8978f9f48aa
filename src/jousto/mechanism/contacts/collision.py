"""Shapes of many bodies that may touch, their surfaces, and the pairs that differ."""

from __future__ import annotations

from math import sqrt
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Name, OptionalItem, Text, field
from jousto.base.numbers import DefaultNumber, Number, OptionalNumber
from jousto.base.object_repr import described
from jousto.materials.material import Material
from jousto.mechanism.bodies.marker import MarkerField
from jousto.mechanism.contacts.friction import default_static
from jousto.mechanism.contacts.laws import ContactLaw, ContactLawField, Hertz
from jousto.mechanism.contacts.shapes import ShapeField

ROLLING = "Length l of the resistance to rolling, a moment up to l N; 0 for none"
DRILLING = "Length l of the resistance to turning about the normal, a moment up to l N; 0 for none"
ALL = "all"
"""Group of the shapes for which none is given."""


class Surface(Declared, by_value=True):
    """What a body is made of where it touches: elasticity, restitution and friction.

    The law between two surfaces is that of Hertz with ``1/E* = sum (1 - nu^2)/E``, the smaller of
    both coefficients of restitution, the geometric mean of both coefficients of friction, and the
    larger one of both lengths of resistance; `SurfacePair` replaces any of it.

    Examples
    --------
    >>> Surface("steel", 210e9, 0.3, restitution=0.8, mu_kinetic=0.15).mu_static
    0.15
    """

    kind = "surface"
    name: Name = field("Name of the surface, by which pairs refer to it")
    E: OptionalNumber = field(
        "Young's modulus; None for the law of the set", unit="Pa", above=0, default=None
    )
    nu: Number = field("Poisson's ratio", unit="1", least=0, most=0.5, default=0.3)
    restitution: Number = field(
        "Coefficient of restitution; 1 for no loss",
        unit="1",
        least=0,
        most=1,
        default=0.5,
        kw_only=True,
    )
    mu_kinetic: Number = field(
        "Coefficient of friction while it slips", unit="1", least=0, default=0.0, kw_only=True
    )
    mu_static: DefaultNumber = field(
        "Coefficient of friction up to which it sticks; None: mu_kinetic",
        unit="1",
        least=0,
        default=None,
        kw_only=True,
    )
    rolling: Number = field(ROLLING, unit="m", least=0, default=0.0, kw_only=True)
    drilling: Number = field(DRILLING, unit="m", least=0, default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        default_static(self)
        super().__post_init__()

    @classmethod
    def of(cls, material: Material, **more: Any) -> Surface:
        """Return the surface of a material, by the name of the material."""
        return cls(material.name or "material", material.E, material.nu, **more)

    def law_with(self, other: Surface) -> Hertz | None:
        """Return the law between this surface and another one; None without their elasticity."""
        if self.E is None or other.E is None:
            return None
        modulus = 1.0 / ((1.0 - self.nu**2) / self.E + (1.0 - other.nu**2) / other.E)
        return Hertz(modulus, restitution=min(self.restitution, other.restitution))

    def friction_with(self, other: Surface) -> tuple[float, float]:
        """Return the kinetic and the static coefficient of friction on another surface."""
        return (
            sqrt(self.mu_kinetic * other.mu_kinetic),
            sqrt(self.mu_static * other.mu_static),
        )

    def lengths_with(self, other: Surface) -> tuple[float, float]:
        """Return the lengths of resistance to rolling and drilling on another surface, m."""
        return max(self.rolling, other.rolling), max(self.drilling, other.drilling)


class OptionalContactLaw(ContactLawField):
    """Field of a law of contact, or None."""

    optional = True


class CollisionShape(Declared):
    """Named shape on a marker of a body, for `Contacts`.

    Examples
    --------
    >>> from jousto import ground
    >>> from jousto.mechanism import HalfSpace
    >>> CollisionShape("floor", ground["origin"], HalfSpace())
    <CollisionShape 'floor'>
    """

    kind = "collision shape"
    name: Name = field("Unique among the shapes of a set")
    marker: MarkerField = field("Marker in whose frame the shape is")
    shape: ShapeField = field("Shape in the frame of the marker")
    surface: OptionalItem[Surface] = field(
        "Surface of the body there; None for the law of the set", default=None, kw_only=True
    )
    group: Text = field(
        "Group of shapes, by which `Apart` excludes pairs", default=ALL, kw_only=True
    )

    @property
    def size(self) -> float:
        """Largest distance from the marker, m; infinite for shapes without end."""
        return self.shape.size_about

    def __repr__(self) -> str:
        return f"<CollisionShape {self.name!r}>"


@described
class SurfacePair(Declared, by_value=True):
    """Law and friction between two surfaces, in place of what follows from each of them."""

    kind = "pair of surfaces"
    a: Text = field("Name of a surface")
    b: Text = field("Name of the other surface, or of the same one")
    law: OptionalContactLaw = field("Law of the normal force; None: that of both", default=None)
    mu_kinetic: OptionalNumber = field(
        "Coefficient of friction while it slips; None: that of both",
        unit="1",
        least=0,
        default=None,
        kw_only=True,
    )
    mu_static: OptionalNumber = field(
        "Coefficient of friction up to which it sticks; None: mu_kinetic if it is given, else "
        "that of both",
        unit="1",
        least=0,
        default=None,
        kw_only=True,
    )
    rolling: OptionalNumber = field(
        "Length of the resistance to rolling; None: that of both",
        unit="m",
        least=0,
        default=None,
        kw_only=True,
    )
    drilling: OptionalNumber = field(
        "Length of the resistance to turning about the normal; None: that of both",
        unit="m",
        least=0,
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a pair that replaces nothing."""
        friction = (self.mu_kinetic, self.mu_static, self.rolling, self.drilling)
        given: tuple[Any, ...] = (self.law, *friction)
        if all(value is None for value in given):
            problems.add(where, "gives neither a law nor friction; give one, or leave it out")

    def applies(self, a: str, b: str) -> bool:
        """Return whether it is the pair of two names, in any order."""
        return (a, b) in ((self.a, self.b), (self.b, self.a))

    def law_or(self, usual: ContactLaw) -> ContactLaw:
        """Return its law, or the usual one."""
        own: Any = self.law
        return usual if own is None else own

    def friction_or(self, usual: tuple[float, float]) -> tuple[float, float]:
        """Return its kinetic and static coefficient of friction, or the usual ones."""
        kinetic = usual[0] if self.mu_kinetic is None else self.mu_kinetic
        if self.mu_static is not None:
            return kinetic, self.mu_static
        return kinetic, usual[1] if self.mu_kinetic is None else kinetic

    def lengths_or(self, usual: tuple[float, float]) -> tuple[float, float]:
        """Return its lengths of resistance to rolling and drilling, or the usual ones, m."""
        own: tuple[Any, Any] = (self.rolling, self.drilling)
        rolling, drilling = (b if a is None else a for a, b in zip(own, usual, strict=True))
        return rolling, drilling


class Apart(Declared, by_value=True):
    """Two shapes or groups of shapes that never touch each other."""

    kind = "excluded pair"
    a: Text = field("Name of a shape, or of a group of shapes")
    b: Text = field("Name of the other one, or of the same group")
