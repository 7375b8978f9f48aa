"""Elements of hydraulic networks, their ports, and inputs that signals or states give."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, Name, Nested, field

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit


class HydraulicElement(Declared, section="hydraulics"):
    """Base of the elements: each adds its flows, volumes and forces to a circuit."""

    kind = "hydraulic element"
    own: ClassVar[bool] = False
    """Whether the element is a place with a pressure, to which ports are connected."""
    name: Name = field("Unique in the network; letters, digits and _")

    @property
    def ports(self) -> dict[str, str]:
        """Names of the nodes, tanks and supplies by port."""
        found = {
            key: getattr(self, key) for key, kind in self.fields.items() if kind.form == "port"
        }
        return {key: name for key, name in found.items() if name is not None}

    def check_with(self, problems: Problems, where: str, circuit: Circuit) -> None:
        """Report what does not fit the network."""

    def connect(self, circuit: Circuit) -> None:
        """Add the equations of the element to a circuit."""
        raise NotImplementedError

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages, ``cylinder 'lift'``; report a name that is no word."""
        where = super().heading(problems)
        name = getattr(self, "name", "")
        if isinstance(name, str) and name and not name.isidentifier():
            problems.add(where, "name must have letters, digits and _ only", "name")
        return where


class _Port(Field["Any", "Any"]):
    form = "port"
    noun = "str, Node, Tank or Supply"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the name of a node, tank or supply, or report another value."""
        if isinstance(value, HydraulicElement) and value.own:
            return value.name
        if not (isinstance(value, str) and value):
            problems.add(
                where, f"{self.name} is {value!r}, must be a node, tank or supply, or its name",
                self.name,
            )  # fmt: skip
            return None
        return value


class Port(_Port):
    """Field of a node, tank or supply to which a port is connected, stored as its name."""


class OptionalPort(_Port):
    """Field of a port, or None."""

    optional = True


class ElementsField(Nested[Any, Any]):
    """Field of several hydraulic elements."""

    form = "several nested"
    section = "hydraulics"
    room = "jousto.mechanism.hydraulics"
    noun = "sequence of hydraulic elements"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the elements as a tuple, or report other values."""
        return problems.several(where, self.label, value, HydraulicElement)
