"""Reference conditions: six conditions that define the body frame of a deforming body."""

from __future__ import annotations

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Nested, Text, field


class Frame(Declared, section="reference conditions", by_value=True):
    """Reference condition of the frame of a flexible body, to first order in the deformation."""


class MeanFrame(Frame, tag="mean"):
    """Mean axes: the deformation has no momentum (Buckens; to first order Tisserand).

    ``int Phi dm = 0`` and ``int u0 x Phi dm = 0``. The kinetic energy of the deformation is
    minimal.

    Examples
    --------
    >>> MeanFrame()
    MeanFrame()
    """


class NodeFrame(Frame, tag="node"):
    """Frame fixed to a node, with its rotation (tangent frame).

    ``Phi = 0`` and ``Psi = 0`` at the node.

    Examples
    --------
    >>> NodeFrame("start")
    NodeFrame(node='start')
    """

    node: Text = field("A node with rotations: an interface, a set of one node or ``node7``")


class ChordFrame(Frame, tag="chord"):
    """Frame with its origin at a node and an axis through another node.

    ``Phi = 0`` at the first node and ``e x Phi = 0`` at the second, where e is the unit vector from
    the first to the second. The rotation about this axis is that of the first node or, if it has no
    rotations, of the second.

    Raises
    ------
    InputError
        If both nodes are the same.

    Examples
    --------
    >>> ChordFrame("start", "end")
    ChordFrame(first='start', second='end')
    """

    first: Text = field("The node at the beginning of the chord")
    second: Text = field("The node at the end of the chord")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a chord between equal nodes."""
        if self.first == self.second:
            problems.add(where, f"first and second are both '{self.first}', must be two nodes")


class AsGiven(Frame, tag="as-given"):
    """Frame implied by shape functions, which remain unchanged.

    Functions clamped at an end imply the frame of that node; functions pinned at both ends imply
    the chord. For `ShapeFunctions` only, since modes of the mesh refer to mean axes.

    Examples
    --------
    >>> AsGiven()
    AsGiven()
    """


class FrameField(Nested["Frame | None", "Frame | None"]):
    """Field of a reference condition; None for the mean axes."""

    section = "reference conditions"
    room = "jousto.reduction.frames.frame"
    noun = "NodeFrame(...), ChordFrame(...) or MeanFrame()"

    def check(self, problems: Problems, where: str, value: Frame | None) -> Frame | None:
        """Return the reference condition, or report a value of another type."""
        if not isinstance(value, Frame):
            problems.add(where, f"{self.name} is {value!r}, must be {self.noun}")
        return value
