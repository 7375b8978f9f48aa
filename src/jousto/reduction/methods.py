"""Methods of reduction, which choose the modes that describe the elastic motion."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, Flag, field
from jousto.base.numbers import OptionalNumber, OptionalWhole
from jousto.reduction.frames.frame import AsGiven, FrameField
from jousto.reduction.modes.residuals import read_residuals
from jousto.reduction.shapes.functions import Functions


class Places(Field["str | Iterable[str]", "tuple[str, ...]"]):
    """Field of names of interfaces or node sets, or of a single name."""

    form = "texts"
    noun = "tuple of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the names; report wrong ones and duplicates."""
        if not isinstance(value, Iterable):
            problems.add(where, f"{self.name} is {value!r}, must be names")
            return ()
        names = (value,) if isinstance(value, str) else tuple(value)
        for name in names:
            if not isinstance(name, str):
                problems.add(
                    where, f"interface {name!r} is not the name of an interface or node set"
                )
            elif names.count(name) > 1:
                problems.add(where, f"interface '{name}' is named more than once")
                break
        return names


class Residuals(Field[Any, "tuple[Any, ...]"]):
    """Field of residual loads, whose static response is exact, and of stress sites."""

    form = "residuals"
    noun = "sequence of (ndof,) or (ndof, m) arrays and str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the residuals as a tuple, or report wrong ones."""
        return read_residuals(where, value, problems)


class Limit(OptionalNumber):
    """Field of the highest kept frequency, Hz."""

    def __init__(self, text: str = "", **common: Any) -> None:
        super().__init__(text, unit="Hz", above=0, wanted="positive, in Hz", plain=True, **common)


class Reduction(Declared, section="reductions", by_value=True):
    """Base of the methods: a choice of modes by number, by frequency or by both."""

    frame: FrameField = field(
        "Reference condition of the body frame: a node, the chord of two nodes, or None for the"
        " mean axes",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a missing limit, and a frame that modes of the mesh cannot have."""
        if isinstance(self.frame, AsGiven):
            problems.add(
                where, "frame is AsGiven(), which is allowed for ShapeFunctions(...) only", "frame"
            )
        if all(getattr(self, key) is None for key in ("modes", "frequency_limit")):
            problems.add(where, "give modes=number or frequency_limit=Hz (or both)")


class CraigBampton(Reduction, tag="craig-bampton"):
    """Craig-Bampton modes: fixed-interface modes, and constraint modes of the interface nodes.

    ``T = [E 0; Phi_C Phi_N]`` (Rantalainen 2007, eqs. 3.24-3.31), then orthonormalised without the
    rigid-body modes (eqs. 3.32-3.36). Each interface node with six degrees of freedom adds six
    constraint modes; the six rigid-body modes are removed, so that ``n = modes + 6 *
    len(interfaces) - 6``. Modes without mass get 10,000 times the lowest frequency, since they are
    static shapes.

    Residual vectors ``(K_II^-1 - Phi_N W^-2 Phi_N^T) f`` add the part of a static response outside
    of the fixed-interface modes: one more mode per load or stress component.

    Raises
    ------
    InputError
        If no limit is given, or a limit or residual cannot be used.

    Examples
    --------
    >>> CraigBampton(interfaces=("start",), modes=4)
    CraigBampton(interfaces=('start',), modes=4, frequency_limit=None)
    """

    interfaces: Places = field(
        "Interfaces or node sets where joints and forces act; every node of a node set becomes "
        "an interface node. Empty for all interfaces of the part",
        default=(),
    )
    modes: OptionalWhole = field(
        "Number of fixed-interface modes, lowest first; 0 for static condensation",
        least=0,
        default=None,
    )
    frequency_limit: Limit = field(
        "Highest frequency of the fixed-interface modes. With `modes`, both limits apply",
        default=None,
    )
    residuals: Residuals = field(
        "Nodal load patterns in the degrees of freedom of the part, any unit, whose static "
        "response becomes exact; or names of stress sites, whose static stress becomes exact "
        "under all loads",
        default=(),
    )
    inertia_relief: Flag = field(
        "Whether the responses to the six rigid accelerations are added: the deformation under "
        "weight and slow acceleration then equals that of the mesh",
        default=False,
    )

    def __repr__(self) -> str:
        more = f", residuals={self.residuals}" if self.residuals else ""
        more += ", inertia_relief=True" if self.inertia_relief else ""
        more += f", frame={self.frame}" if self.frame else ""
        return (
            f"CraigBampton(interfaces={self.interfaces}, modes={self.modes}, "
            f"frequency_limit={self.frequency_limit}{more})"
        )


class FreeFree(Reduction, tag="free-free"):
    """Free-free elastic modes of the whole part, without interfaces.

    Suitable for a part without supports. Near a joint they converge more slowly than
    `CraigBampton`, unless attachment modes are added: the residual response of the accelerated part
    to unit forces and moments on the interfaces (MacNeal 1971, Rubin 1975).

    Raises
    ------
    InputError
        If no limit is given, or a limit or residual cannot be used.

    Examples
    --------
    >>> FreeFree(frequency_limit=500.0)
    FreeFree(modes=None, frequency_limit=500.0)
    """

    modes: OptionalWhole = field(
        "Number of elastic modes, lowest first, without the rigid-body modes",
        least=0,
        default=None,
    )
    frequency_limit: Limit = field(
        "Highest frequency of the modes. With `modes`, both limits apply", default=None
    )
    interfaces: Places = field("Interfaces or node sets with attachment modes", default=())
    residuals: Residuals = field("Load patterns and stress sites, see `CraigBampton`", default=())

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a method without modes."""
        super().consistent(problems, where)
        if self.modes == 0 and not self.residuals and not self.interfaces:
            problems.add(where, "modes is 0, must be at least 1", "modes")

    def __repr__(self) -> str:
        more = f", interfaces={self.interfaces}" if self.interfaces else ""
        more += f", residuals={self.residuals}" if self.residuals else ""
        more += f", frame={self.frame}" if self.frame else ""
        return f"FreeFree(modes={self.modes}, frequency_limit={self.frequency_limit}{more})"


class ShapeFunctions(Reduction, tag="shape-functions"):
    """Shape functions of position in place of modes of the mesh (Ritz method).

    ``u = T q`` with the functions' values T at the nodes; mass and stiffness are ``T^T M T`` and
    ``T^T K T`` of the part's own matrices. Rigid motions are removed, since the frame describes
    them, and the rest is orthonormalised. The results are the best approximations of the modes of
    the part by these functions. Interfaces and residuals add their static responses, as in
    `FreeFree`.

    A callable has the positions of all nodes (nn, 3) in m as argument and returns translations (nn,
    3), any unit; for parts of beams it may return translations and rotations (nn, 6). Missing
    rotations of beam nodes are those of minimal strain energy. Columns are displacements (ndof,) or
    (ndof, m) in the part's degrees of freedom.

    Raises
    ------
    InputError
        If there is no function, or an argument is invalid.

    Examples
    --------
    A cantilever with three functions in each direction; slender beam theory gives 8.3552 Hz:

    >>> import jousto as jo
    >>> from jousto.reduction import BeamFunctions, NodeFrame, ShapeFunctions
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 20, steel)
    >>> by = ShapeFunctions(BeamFunctions("clamped-free", 3), frame=NodeFrame("start"))
    >>> jo.reduce(part, by).frequencies[0].round(2)
    np.float64(8.35)
    """

    functions: Functions = field(
        "Families of functions (beam eigenfunctions, polynomials, splines); in Python also "
        "functions of position and columns over the nodes"
    )
    interfaces: Places = field("Interfaces or node sets with attachment modes", default=())
    modes: OptionalWhole = field(
        "Number of modes, lowest first; None for all",
        least=1,
        default=None,
    )
    frequency_limit: Limit = field(
        "Highest frequency of the modes. With `modes`, both limits apply", default=None
    )
    residuals: Residuals = field("Load patterns and stress sites, see `CraigBampton`", default=())

    def consistent(self, problems: Problems, where: str) -> None:
        """Accept missing limits, with which all modes are kept."""

    def __repr__(self) -> str:
        more = "".join(
            f", {key}={value}"
            for key in ("interfaces", "modes", "frequency_limit", "residuals", "frame")
            if (value := getattr(self, key)) not in ((), None)
        )
        return f"ShapeFunctions({self.functions}{more})"


Method = CraigBampton | FreeFree | ShapeFunctions
