"""Likeness: links and layout that models of equal structure share."""

from __future__ import annotations

from dataclasses import dataclass

from jousto.model.model import Model
from jousto.model.native.layout import lay_out_like, share_layout

COUNTS = ("nx", "nu")  # counts of a model that depend on its links


@dataclass(frozen=True, eq=False)
class Likeness:
    """Models of one structure: before and after the links of the tree were found.

    Attributes
    ----------
    closed, made : Model
        Model of a mechanism with its initial state, without and with links.
    """

    closed: Model
    made: Model

    def fits(self, model: Model) -> bool:
        """Return whether a model of equal structure has the same links.

        Links depend on the pose at the start, and free ones on the masses.
        """
        free = any(link.kind == "free" for link in self.made.tree)
        heavier = free and any(
            a.mass[0] != b.mass[0]
            for a, b in zip(self.closed.bodies, model.bodies, strict=True)
            if a is not b
        )
        same = model.q0.tobytes() == self.closed.q0.tobytes()
        return same and not heavier and model.redundant == self.closed.redundant

    def with_links(self, model: Model) -> Model:
        """Return a model with the links of these models, and the same layout."""
        counts = {key: vars(self.made)[key] for key in COUNTS if key in vars(self.made)}
        made = model.with_records(tree=self.made.tree, elimination=self.made.elimination, **counts)
        if self.made.tree_of:
            vars(made)["tree_of"] = made.parts_of_tree
        vars(made)["structure"] = self.made
        lay_out_like(made, self.made)
        share_layout(made, model)
        return made
