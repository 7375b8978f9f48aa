"""Reference conditions: which six motions of a deforming body its frame follows."""

from __future__ import annotations

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Nested, Text, field


class Frame(Declared, section="reference conditions", by_value=True):
    """How the frame of a flexible body follows it, to the first order in its deformation."""


class MeanFrame(Frame, tag="mean"):
    """The mean axes: the deformation has no momentum (Buckens; to first order Tisserand's).

    ``int Phi dm = 0`` and ``int u0 x Phi dm = 0``. Kinetic energy of the deformation is least.

    Examples
    --------
    >>> MeanFrame()
    MeanFrame()
    """


class NodeFrame(Frame, tag="node"):
    """A frame that sits on a node and turns with it (tangent frame).

    ``Phi = 0`` and ``Psi = 0`` there.

    Examples
    --------
    >>> NodeFrame("start")
    NodeFrame(node='start')
    """

    node: Text = field("A node that turns: an interface, a set of one node or ``node7``")


class ChordFrame(Frame, tag="chord"):
    """A frame that starts at a node and whose axis goes through another one.

    ``Phi = 0`` at the first and ``e x Phi = 0`` at the second, e the unit vector from one to the
    other; about this axis the frame turns with the first of them that turns.

    Raises
    ------
    InputError
        Both are the same.

    Examples
    --------
    >>> ChordFrame("start", "end")
    ChordFrame(first='start', second='end')
    """

    first: Text = field("The node at the beginning of the chord")
    second: Text = field("The node that the chord goes through")

    def consistent(self, problems: Problems, where: str) -> None:
        """Note that there is no chord."""
        if self.first == self.second:
            problems.add(where, f"first and second are both '{self.first}', must be two nodes")


class AsGiven(Frame, tag="as-given"):
    """The frame that shape functions imply: they are taken as they are.

    Clamped functions thus have the frame of the clamped node, those pinned at both ends the
    chord. For `ShapeFunctions` only: modes of the mesh are those of mean axes.

    Examples
    --------
    >>> AsGiven()
    AsGiven()
    """


class FrameField(Nested["Frame | None", "Frame | None"]):
    """A reference condition, or None for the mean axes."""

    section = "reference conditions"
    room = "jousto.reduction.frames.frame"
    noun = "NodeFrame(...), ChordFrame(...) or MeanFrame()"

    def check(self, problems: Problems, where: str, value: Frame | None) -> Frame | None:
        """Return it."""
        if not isinstance(value, Frame):
            problems.add(where, f"{self.name} is {value!r}, must be {self.noun}")
        return value
