"""Families of shape functions: their base class, and functions of the user."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Field

if TYPE_CHECKING:
    from jousto.parts.part import Part

Form = Callable[[Array], Any]


@dataclass(frozen=True, eq=False)
class Columns:
    """Displacements of the nodes for several functions.

    Parameters
    ----------
    names : tuple of str
        Names of the functions in messages.
    values : (nn, d, m) array
        Translations, also rotations if d = 6, in any unit, since only shapes matter.
    turned : bool
        Whether rotations are given; if not, the rotations with minimal strain energy are used.
    """

    names: tuple[str, ...]
    values: Array
    turned: bool = True


class Family(Declared, section="shape functions", by_value=True):
    """Base of families of functions.

    Subclasses return their displacements in `columns`.
    """

    whole: ClassVar[bool] = False
    """Whether the family contains rigid motions, which are removed."""

    if TYPE_CHECKING:

        def columns(self, part: Part) -> Columns: ...  # noqa: D102


class Given:
    """Function of position given by the user, or displacements of nodes, as part of a method.

    Parameters
    ----------
    given : callable or (nn, 3), (nn, 6), (ndof,) or (ndof, m) array
        A callable has all positions (nn, 3), m, as argument and returns (nn, 3) or (nn, 6).
    """

    whole: ClassVar[bool] = False

    def __init__(self, given: Form | Array) -> None:
        self.given = given
        if callable(given):
            self.name = str(getattr(given, "__name__", type(given).__name__))
        else:
            text = f"{given.shape}".encode() + np.ascontiguousarray(given).tobytes()
            self.name = f"columns {hashlib.sha256(text).hexdigest()[:16]}"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Given):
            return False
        return self.given is other.given or (
            not callable(self.given) and not callable(other.given) and self.name == other.name
        )

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<{self.name}>"

    def columns(self, part: Part) -> Columns:
        """Return the values of the function at the nodes of a part."""
        if callable(self.given):
            return self._called(part)
        nn, d = len(part.nodes), part.dofs_per_node
        if len(self.given) != nn * d:
            message = (
                f"shape functions by columns have {len(self.given)} rows, the part has {nn * d} "
                "degrees of freedom"
            )
            raise InputError(Problem(f"part '{part.name}'", message))
        values = self.given.reshape(nn, d, -1)
        names = tuple(f"column {j + 1}" for j in range(values.shape[2]))
        return Columns(names, values)

    def _called(self, part: Part) -> Columns:
        where, nn, d = f"part '{part.name}'", len(part.nodes), part.dofs_per_node
        assert callable(self.given)
        try:
            found = np.asarray(self.given(part.nodes.copy()), dtype=np.float64)
        except Exception as error:
            kind = type(error).__name__
            message = f"shape function '{self.name}' failed at the nodes: {kind}: {error}"
            raise InputError(Problem(where, message)) from error
        shapes = [(nn, 3), (nn, 6)][: 1 + (d == 6)]
        if found.shape not in shapes:
            wanted = " or ".join(map(str, shapes))
            message = (
                f"shape function '{self.name}' returns an array {found.shape} for the {nn} nodes, "
                f"must be {wanted}: translations of every node"
                + (", and if they are known its rotations" if d == 6 else "")
            )
            raise InputError(Problem(where, message))
        values = np.zeros((nn, d, 1))
        values[:, : found.shape[1], 0] = found
        return Columns((f"'{self.name}'",), values, turned=found.shape[1] == d)


class Functions(Field[Any, "tuple[Any, ...]"]):
    """Field of families of shape functions, functions of position and columns, or a single one."""

    form = "shape functions"
    noun = "sequence of BeamFunctions, Polynomials, Splines, callables and (ndof, m) arrays"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the functions as a tuple, or report wrong ones."""
        return read_functions(where, value, problems)


def read_functions(where: str, given: Any, problems: Problems) -> tuple[Any, ...]:
    """Return the functions of a method, or report what is wrong with them."""
    items = given if isinstance(given, list | tuple) else (given,)
    found: list[Any] = []
    for item in items:
        if isinstance(item, Family | Given):
            found.append(item)
        elif isinstance(item, np.ndarray):
            columns = problems.array(
                where, "columns of shape functions", item, (None,) * min(max(item.ndim, 1), 2)
            )
            if columns is not None:
                found.append(Given(columns))
        elif callable(item) and not isinstance(item, type):
            found.append(Given(item))
        else:
            problems.add(
                where,
                f"function {item!r} is not a shape function: give BeamFunctions(...), "
                f"Polynomials(...), "
                "Splines(...), a function of the positions (nn, 3), or columns (ndof, m)",
                "function",
            )
    if not items:
        problems.add(where, "functions is empty, give at least one", "functions")
    return tuple(found)
