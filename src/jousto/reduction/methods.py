"""Which modes describe the elastic motion: the options of `reduce`."""

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
    """Names of interfaces or node sets, or a single one."""

    form = "texts"
    noun = "tuple of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the names; note what is none, and what is named twice."""
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
    """Loads whose static response is exact, and stress sites."""

    form = "residuals"
    noun = "sequence of (ndof,) or (ndof, m) arrays and str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        return read_residuals(where, value, problems)


class Limit(OptionalNumber):
    """The highest frequency kept, Hz."""

    def __init__(self, text: str = "", **common: Any) -> None:
        super().__init__(text, unit="Hz", above=0, wanted="positive, in Hz", plain=True, **common)


class Reduction(Declared, section="reductions", by_value=True):
    """A choice of modes, up to a number, a frequency or both."""

    frame: FrameField = field(
        "How the frame follows the body: a node, the chord of two nodes, or the mean axes if not "
        "given",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Note that no limit is given, or a frame that modes of the mesh do not have."""
        if isinstance(self.frame, AsGiven):
            problems.add(where, "frame is AsGiven(), which only ShapeFunctions(...) have", "frame")
        if all(getattr(self, key) is None for key in ("modes", "frequency_limit")):
            problems.add(where, "give modes=number or frequency_limit=Hz (or both)")


class CraigBampton(Reduction, tag="craig-bampton"):
    """Fixed-interface modes plus constraint modes of the interface nodes.

    ``T = [E 0; Phi_C Phi_N]`` (Rantalainen 2007, eqs. 3.24-3.31), then orthonormalised and freed
    of the rigid-body modes (eqs. 3.32-3.36). One interface node of six degrees of freedom adds
    six constraint modes; the six rigid-body modes are taken away, so that
    ``n = modes + 6 * len(interfaces) - 6``. Of these, motions that move no mass
    stand at 10,000 times the lowest frequency, as the static shapes that they are.

    Residual vectors ``(K_II^-1 - Phi_N W^-2 Phi_N^T) f`` add what the fixed-interface modes leave
    out of a static response: one more mode for each load or stress component.

    Raises
    ------
    InputError
        Neither limit given, or a limit or residual that cannot be used.

    Examples
    --------
    >>> CraigBampton(interfaces=("start",), modes=4)
    CraigBampton(interfaces=('start',), modes=4, frequency_limit=None)
    """

    interfaces: Places = field(
        "Where joints and forces act: interfaces of the part, or node sets, of which every node is "
        "an interface node then. All interfaces of the part if none is named",
        default=(),
    )
    modes: OptionalWhole = field(
        "Number of fixed-interface modes, the lowest are taken; 0 is static condensation",
        least=0,
        default=None,
    )
    frequency_limit: Limit = field(
        "Highest fixed-interface frequency kept. With `modes` as well, both limits hold",
        default=None,
    )
    residuals: Residuals = field(
        "Nodal load patterns in the part's degrees of freedom, any unit: the static response to "
        "them is exact. Names of stress sites: their static stress is exact under all loads",
        default=(),
    )
    inertia_relief: Flag = field(
        "Whether the response to the six rigid accelerations is added too: weight and slow "
        "acceleration then act on the part as on its mesh",
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
    """Free-free elastic modes of the whole part: no interface.

    Good for a part without supports; near a joint they converge slower than `CraigBampton`,
    unless attachment modes are added: what the modes leave out of the response to unit forces and
    moments on the interfaces of the accelerated part (MacNeal 1971, Rubin 1975).

    Raises
    ------
    InputError
        Neither limit given, or a limit or residual that cannot be used.

    Examples
    --------
    >>> FreeFree(frequency_limit=500.0)
    FreeFree(modes=None, frequency_limit=500.0)
    """

    modes: OptionalWhole = field(
        "Number of elastic modes, the lowest are taken. The rigid-body modes do not count",
        least=0,
        default=None,
    )
    frequency_limit: Limit = field(
        "Highest frequency kept. With `modes` as well, both limits hold", default=None
    )
    interfaces: Places = field("Interfaces or node sets that get attachment modes", default=())
    residuals: Residuals = field("Load patterns and stress sites as in `CraigBampton`", default=())

    def consistent(self, problems: Problems, where: str) -> None:
        """Note that there would be no mode."""
        super().consistent(problems, where)
        if self.modes == 0 and not self.residuals and not self.interfaces:
            problems.add(where, "modes is 0, must be at least 1", "modes")

    def __repr__(self) -> str:
        more = f", interfaces={self.interfaces}" if self.interfaces else ""
        more += f", residuals={self.residuals}" if self.residuals else ""
        more += f", frame={self.frame}" if self.frame else ""
        return f"FreeFree(modes={self.modes}, frequency_limit={self.frequency_limit}{more})"


class ShapeFunctions(Reduction, tag="shape-functions"):
    """Functions of position instead of modes of the mesh: Ritz' method.

    ``u = T q`` with the functions' values T at the nodes; mass and stiffness are
    ``T^T M T`` and ``T^T K T`` of the part's own matrices. Rigid motions are taken out, which the
    frame carries, and what is left is made orthonormal, so that the modes of the part are the best
    that the functions can do. With interfaces or residuals come their static responses, as in
    `FreeFree`.

    A callable gets the positions of all nodes (nn, 3) in m and returns translations (nn, 3), any
    unit; in parts of beams also translations and rotations (nn, 6). Without them nodes of beams
    turn such that the strain energy is least. Columns are displacements (ndof,) or (ndof, m) in the
    part's degrees of freedom.

    Raises
    ------
    InputError
        No function, or what is none.

    Examples
    --------
    A cantilever by three functions in each direction; slender beam theory gives 8.3552 Hz:

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
    interfaces: Places = field("Interfaces or node sets that get attachment modes", default=())
    modes: OptionalWhole = field(
        "Number of modes of the functions kept, the lowest are taken; all if not given",
        least=1,
        default=None,
    )
    frequency_limit: Limit = field(
        "Highest frequency of these kept. With `modes` as well, both limits hold", default=None
    )
    residuals: Residuals = field("Load patterns and stress sites as in `CraigBampton`", default=())

    def consistent(self, problems: Problems, where: str) -> None:
        """Nothing: without limits all are kept."""

    def __repr__(self) -> str:
        more = "".join(
            f", {key}={value}"
            for key in ("interfaces", "modes", "frequency_limit", "residuals", "frame")
            if (value := getattr(self, key)) not in ((), None)
        )
        return f"ShapeFunctions({self.functions}{more})"


Method = CraigBampton | FreeFree | ShapeFunctions
