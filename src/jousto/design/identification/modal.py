"""Modal: frequencies, damping and shapes of a hammer test, paired with the modes of a machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count, warn
from jousto.base.files import check_input
from jousto.base.object_repr import described
from jousto.design.identification.bench import StillBench, machines_of
from jousto.design.identification.experiment import Comparison
from jousto.design.identification.mode_pairs import Pairing, pair_modes
from jousto.design.studies.case import Settings
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.evaluator import Evaluator
from jousto.model.model import Model
from jousto.simulation.modes.linear import MechanismModes, modes, nodal_displacements, rotations

REAL = 0.9
"""Collinearity of a complex shape below which its real part is warned about."""
TWICE = 3
"""Modes of the machine that are computed for each measured one, at least."""
MORE = 10
SHARE = 1e-2
"""Deviation of shapes that are not given, of the largest value; that of frequencies is a tenth."""


@explained
@described
@dataclass(frozen=True, eq=False)
class Modal:
    """Modes of a hammer test: frequencies, shapes at some places, damping ratios.

    Parameters
    ----------
    frequencies : (k,) array_like
        Hz.
    shapes : (k, m) array_like, optional
        Shapes at the measured places, each of any scale and sign; complex ones are turned to real.
    places : (m, 3) array_like, optional
        Where each value was measured, in the ground's frame, m; the nearest node of a body counts.
    directions : (m, 3) array_like, optional
        Direction of each value, in the ground's frame.
    damping : (k,) array_like, optional
        Damping ratios; with them the modes are those of the damped machine.
    frequency_noise, shape_noise, damping_noise : float
        Standard deviations: shares of each frequency, of the largest value of a shape, and of each
        damping ratio.
    reach : float
        Largest distance between a place and its node, m.
    close : float, optional
        Relative difference of measured frequencies below which modes are compared together, as the
        space that their shapes span; by default `frequency_noise`, within which two modes cannot be
        told apart.
    state : callable, optional
        Function of the model that returns the state, such as `jo.equilibrium`; by default the
        initial one.
    model : callable, ModelFile, Mechanism or Model, optional
        Machine of this test, if it is not that of the others.
    name : str
        Name for tables.

    Raises
    ------
    InputError
        With all problems of the arrays.

    Examples
    --------
    >>> Modal([10.2, 48.1])
    <Modal 'modes': 2 modes, 10.2 to 48.1 Hz>
    """

    frequencies: ArrayLike
    shapes: ArrayLike | None = None
    places: ArrayLike | None = None
    directions: ArrayLike | None = None
    damping: ArrayLike | None = None
    frequency_noise: float = 1e-3
    shape_noise: float = SHARE
    damping_noise: float = 5e-2
    reach: float = 1e-2
    close: float | None = None
    state: Any = None
    model: Any = None
    name: str = "modes"

    def __post_init__(self) -> None:
        problems, where = Problems(), self.where
        f = problems.array(where, "frequencies", self.frequencies, (None,))
        if f is not None:
            if not len(f) or np.any(f <= 0.0):
                problems.add(where, "frequencies must be positive; leave rigid motions out")
            object.__setattr__(self, "frequencies", f)
        k = 0 if f is None else len(f)
        if self.damping is not None:
            zeta = problems.array(where, "damping", self.damping, (k,))
            if zeta is not None and np.any(zeta <= 0.0):
                problems.add(where, "damping must be positive")
            object.__setattr__(self, "damping", zeta)
        if self.shapes is not None:
            self._check_shapes(problems, k)
        elif self.places is not None or self.directions is not None:
            problems.add(where, "places and directions are given, but no shapes")
        for name in ("frequency_noise", "shape_noise", "damping_noise", "reach"):
            problems.positive(where, name, getattr(self, name), "")
        if self.close is not None:
            problems.number(where, "close", self.close, "", "0 or more", lambda x: x >= 0.0)
        problems.raise_if_any()

    def _check_shapes(self, problems: Problems, k: int) -> None:
        """Check shapes with places and directions, and turn complex shapes to real ones."""
        where = self.where
        shapes: NDArray[Any] = np.asarray(self.shapes)
        if shapes.ndim != 2 or shapes.shape[0] != k or shapes.dtype.kind not in "fciu":
            problems.add(where, f"shapes have shape {shapes.shape}, must be ({k}, m): a row a mode")
            return
        if not np.all(np.isfinite(shapes)) or np.any(np.abs(shapes).max(axis=1) == 0.0):
            problems.add(where, "shapes contain values that are not finite, or a mode of zeros")
            return
        if shapes.dtype.kind == "c":
            shapes = np.array([self._turned(i, row) for i, row in enumerate(shapes)])
        object.__setattr__(self, "shapes", shapes.astype(float))
        m = shapes.shape[1]
        for name in ("places", "directions"):
            given = getattr(self, name)
            if given is None:
                problems.add(where, f"{name} are missing, must be ({m}, 3): a row a value")
                continue
            array = problems.array(where, name, given, (m, 3))
            if array is not None and name == "directions":
                length = np.linalg.norm(array, axis=1)
                if np.any(length == 0.0):
                    problems.add(where, "a direction is zero")
                array = array / np.where(length > 0.0, length, 1.0)[:, None]
            object.__setattr__(self, name, array)

    def _turned(self, i: int, row: NDArray[Any]) -> Array:
        """Return a complex shape turned to the real axis; warn if it is far from real."""
        angle = 0.5 * np.angle(np.sum(row**2))
        turned = row * np.exp(-1j * angle)
        collinear = np.sum(turned.real**2) / np.sum(np.abs(row) ** 2)
        if collinear < REAL:
            warn(
                self.where,
                f"shape of mode {i + 1} is complex (collinearity {collinear:.2f}); its real part "
                "is compared",
            )
        return np.asarray(turned.real)

    @property
    def where(self) -> str:
        """Name in messages."""
        return f"modal data {self.name!r}"

    @property
    def free(self) -> tuple[Parameter, ...]:
        """Sought numbers of channels: none."""
        return ()

    def _facts(self) -> str:
        f: Array = np.asarray(self.frequencies)
        return f"{count(len(f), 'mode')}, {f[0]:.4g} to {f[-1]:.4g} Hz"


@explained
def read_modes(path: str | Path, **options: Any) -> Modal:
    """Return the modes of a universal file: data sets 15 (nodes), 55 (modes) and 164 (units).

    Directions in which all modes are exactly 0 count as not measured. Damping ratios of the file
    are left out unless ``damping=True``.

    Parameters
    ----------
    path : path
    **options
        Further arguments of `Modal`.

    Raises
    ------
    InputError
        If the file does not exist, is no universal file, or has no modes.
    """
    file, where = Path(path), str(path)
    check_input(file)
    try:
        import pyuff
    except ImportError:
        raise InputError(Problem(where, "universal files need pyuff: pip install pyuff")) from None
    try:
        read = pyuff.UFF(where).read_sets()
    except Exception as error:
        raise InputError(Problem(where, f"cannot be read as a universal file: {error}")) from error
    sets: list[dict[str, Any]] = read if isinstance(read, list) else [read]
    found = [s for s in sets if s.get("type") == 55 and s.get("analysis_type") in (2, 3)]
    nodes = [s for s in sets if s.get("type") in (15, 2411)]
    if not found or not nodes:
        kinds = ", ".join(sorted({str(s.get("type")) for s in sets})) or "none"
        message = "needs nodes (data set 15) and modes (data set 55); it has data sets"
        raise InputError(Problem(where, f"{message} {kinds}"))
    scale = next((1.0 / float(s["length"]) for s in sets if s.get("type") == 164), 1.0)
    places = {
        int(n): scale * np.array([x, y, z], dtype=float)
        for s in nodes
        for n, x, y, z in zip(s["node_nums"], s["x"], s["y"], s["z"], strict=True)
    }
    measured = [int(n) for n in found[0]["node_nums"]]
    missing = [n for n in measured if n not in places]
    if missing:
        raise InputError(Problem(where, f"modes have nodes without a place: {missing[:6]}"))
    each = np.array([[s["r1"], s["r2"], s["r3"]] for s in found])  # (k, 3, nodes)
    used = np.any(each != 0.0, axis=0)
    axes, at = np.nonzero(used)
    damping = options.pop("damping", None)
    if damping is True:
        damping = [float(s.get("modal_damp_vis", 0.0)) for s in found]
    given = {"name": file.name} | options
    return Modal(
        [_frequency(s) for s in found],
        each[:, axes, at],
        [places[measured[i]] for i in at],
        np.eye(3)[axes],
        damping,
        **given,
    )


def _frequency(s: dict[str, Any]) -> float:
    """Return the frequency of a mode, Hz: of a normal mode, or of a complex eigenvalue."""
    if "freq" in s:
        return float(s["freq"])
    return abs(complex(s["eig"])) / (2.0 * np.pi)


class ModalBench(StillBench):
    """Bench of a hammer test; see `Bench`. Its result is a `Pairing`."""

    @property
    def scales(self) -> int:
        """Number of scales of shapes, which take a degree of freedom each."""
        return 0 if self.experiment.shapes is None else len(np.asarray(self.experiment.frequencies))

    def results(self, points: Sequence[Array]) -> list[Any]:
        """Return the pairing of modes at points (np,) of all unknowns, or the error of each."""
        found: list[Any] = []
        with self.evaluator.count_warnings():
            for theta in points:
                try:
                    model = self.evaluator.case(np.asarray(theta)[self.places]).model
                    found.append(self._paired(model))
                except Exception as error:
                    found.append(error)
        self.evaluator.memory.counts["runs"] += len(points)
        return found

    def _paired(self, model: Model) -> Pairing:
        """Return the measured modes with those of a machine."""
        given = self.experiment
        state = None if given.state is None else given.state(model)
        f = np.asarray(given.frequencies)
        damped = given.damping is not None
        made = modes(model, state, damped=damped, count=TWICE * len(f) + MORE)
        kept = made.frequencies > 0.0
        shapes = None if given.shapes is None else self._at_places(model, made)[kept]
        return pair_modes(
            f,
            None if given.shapes is None else np.asarray(given.shapes),
            made.frequencies[kept],
            shapes,
            made.damping[kept] if damped else None,
            given.frequency_noise if given.close is None else given.close,
        )

    def _at_places(self, model: Model, made: MechanismModes) -> Array:
        """Return the shapes (modes, m) of a machine at the measured places and directions."""
        q = made.state.q
        moved = nodal_displacements(model, q, made.increments)
        nodes, each = [], []
        for body, shape, A in zip(model.bodies, model.shapes, rotations(model, q), strict=True):
            u = shape.nodes
            if body.n:
                u = u + shape.modes @ q[body.iq + 7 : body.iq + 7 + body.n]
            nodes.append(q[body.iq : body.iq + 3] + u @ A.T)
            each.append(moved[body.name])
        every, displacements = np.vstack(nodes), np.concatenate(each, axis=1)
        places = np.asarray(self.experiment.places)
        distance = np.linalg.norm(every[None] - places[:, None], axis=2)
        near = distance.argmin(axis=1)
        far = distance[np.arange(len(places)), near] > self.experiment.reach
        if np.any(far):
            i = int(np.argmax(far))
            message = (
                f"no node within {self.experiment.reach:g} m of the place "
                f"({', '.join(f'{x:g}' for x in places[i])}); the nearest is "
                f"{distance[i].min():.3g} m away"
            )
            raise InputError(Problem(self.experiment.where, message))
        found = np.einsum(
            "kmi,mi->km", displacements[:, near], np.asarray(self.experiment.directions)
        )
        return _real(found)

    def compare(self, problems: Problems, result: Pairing) -> tuple[Comparison, ...]:
        """Return a comparison for each frequency, damping ratio and shape."""
        given = self.experiment
        f = np.asarray(given.frequencies)
        found: list[Comparison] = []
        for i, value in enumerate(f):
            found.append(_single(f"f{i + 1}", "Hz", value, given.frequency_noise * value))
        if given.damping is not None:
            for i, value in enumerate(np.asarray(given.damping)):
                found.append(_single(f"damping {i + 1}", "1", value, given.damping_noise * value))
        if given.shapes is not None:
            for i, row in enumerate(np.asarray(given.shapes)):
                m = len(row)
                each = np.arange(m, dtype=float), row / np.abs(row).max()
                sd = np.full(m, given.shape_noise)
                name = f"shape {i + 1}"
                found.append(Comparison(name, name, "1", *each, sd, 1.0, 0.0, 0.0))
        return tuple(found)

    def show(self, result: Pairing, comparison: Comparison, shift: float) -> tuple[Array, Array]:
        """Return the computed frequency, damping ratio or shape of a comparison."""
        kind, _, number = comparison.channel.rpartition(" ")
        if not kind:
            values = result.frequencies[int(comparison.channel[1:]) - 1 :][:1]
        elif kind == "damping":
            values = result.damping[int(number) - 1 :][:1]
        else:
            values = result.shape(int(number) - 1)
        return values, np.zeros(len(values))


def _single(name: str, unit: str, value: float, sd: float) -> Comparison:
    """Return the comparison of one number."""
    each = np.zeros(1), np.array([value]), np.array([sd])
    return Comparison(name, name, unit, *each, 1.0, 0.0, 0.0)


def _real(shapes: NDArray[Any]) -> Array:
    """Return shapes turned to the real axis; those of undamped modes are real."""
    if not np.iscomplexobj(shapes):
        return np.asarray(shapes, dtype=float)
    angle = 0.5 * np.angle(np.sum(shapes**2, axis=1))
    return np.asarray((shapes * np.exp(-1j * angle)[:, None]).real)


def make_modal_bench(
    problems: Problems, experiment: Modal, model: Any, parameters: Sequence[Parameter]
) -> ModalBench | None:
    """Return the bench of a hammer test; None, with problems, if there is none."""
    made = machines_of(problems, experiment, model, parameters, Settings())
    if made is None:
        return None
    return ModalBench(experiment, Evaluator(made.source, made.parameters, ()), made.places)
