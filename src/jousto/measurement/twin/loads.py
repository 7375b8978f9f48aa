"""Loads from strains: modal loads by Fourier series, loads at known places, payload."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Estimates
from jousto.measurement.twin.motion.reference import STILL, InertialForce, Reference
from jousto.measurement.twin.motion.system import UnknownLoad
from jousto.measurement.twin.observer import Observer
from jousto.measurement.twin.reconstruction import Reconstruction
from jousto.measurement.twin.signals import read_strain, read_time
from jousto.measurement.twin.smoother import sample_posterior, smooth
from jousto.reduction.damping import modal_damping
from jousto.reduction.reduced import ReducedPart

UNEVEN = 1e-6
"""Relative variation of time steps up to which a record counts as uniform."""


@described
@dataclass(frozen=True, eq=False)
class FourierLoads:
    """Modal loads over a window of time as a Fourier series.

    ``f = f_0 + sum_j [f_j cos(j w t) + s_j sin(j w t)]``, t from the start of the window.

    Attributes
    ----------
    base : float
        ``w = 2 pi / T``, rad/s, of the window T; not a natural frequency.
    start : float
        Start of the window, s.
    constant : (n,) array
        f_0, kg^0.5 m/s2.
    cosine, sine : (nh, n) arrays
        f_j and s_j of the harmonics j = 1 .. nh.
    coordinates : (nh + 1, n) complex array
        Modal coordinates ``p_j - i r_j`` of the constant and the harmonics, kg^0.5 m.
    """

    base: float
    start: float
    constant: Array
    cosine: Array
    sine: Array
    coordinates: NDArray[np.complex128]

    def at(self, time: ArrayLike) -> Array:
        """Return the modal loads (nt, n) at times, s."""
        phase = np.outer(np.atleast_1d(time) - self.start, self.base * self.harmonics)
        return np.asarray(self.constant + np.cos(phase) @ self.cosine + np.sin(phase) @ self.sine)

    @property
    def harmonics(self) -> Array:
        """Orders of the harmonics, 1 .. nh."""
        return np.arange(1, len(self.cosine) + 1, dtype=np.float64)

    @property
    def frequencies(self) -> Array:
        """Frequencies of the harmonics, Hz."""
        return self.base * self.harmonics / (2.0 * np.pi)


@explained
def identify_fourier(
    twin: Reconstruction,
    time: ArrayLike,
    e: ArrayLike,
    part: ReducedPart | ArrayLike,
    *,
    damping: Any = 0.0,
    harmonics: int | None = None,
    limit: float | None = None,
) -> FourierLoads:
    """Return the Fourier series of modal loads from the strains in a time window.

    ``f_0 = W2 B^+ e_0``, ``f_j - i s_j = (W2 - j^2 w^2 + 2 i j w Z W) B^+ (e_j - i k_j)``: exact
    for strains that repeat with the window; the response before it must have died away or repeat.
    Errors grow with the square of the frequency: keep the harmonics below the highest mode that the
    gauges can distinguish.

    Parameters
    ----------
    twin : Reconstruction
        Reconstruction that provides ``B^+``, weighted and regularised.
    time : (nt,) array_like
        Instants, s, evenly spaced; the window ends one step after the last.
    e : (nt, ng) array_like
        Strains, m/m, without gaps.
    part : ReducedPart or (n,) or (n, n) array_like
        Modal stiffness: that of the part or ``omega^2``, 1/s2. For a clamped body the result of
        `clamp`.
    damping : float, sequence of float or Rayleigh
        Damping as in `FlexibleBody`.
    harmonics : int, optional
        Number of harmonics; by default all up to half the sampling rate.
    limit : float, optional
        Highest frequency, Hz.

    Raises
    ------
    InputError
        For uneven times, gaps, or wrong sizes.
    """
    problems = Problems()
    where = "identify_fourier"
    strain = read_strain(problems, where, e, twin.names)
    t = read_time(problems, where, time, strain)
    if strain is not None and np.isnan(strain).any():
        problems.add(where, "the strains have gaps (nan); a Fourier series needs every sample")
    if t is not None and (len(t) < 3 or np.ptp(np.diff(t)) > UNEVEN * np.diff(t).mean()):
        problems.add(where, "the times must be evenly spaced, at least 3; resample the record")
    w2 = part.stiffness if isinstance(part, ReducedPart) else np.asarray(part, dtype=np.float64)
    if w2.ndim == 2:
        if np.abs(w2 - np.diag(np.diag(w2))).max(initial=0.0) > 1e-9 * np.abs(w2).max(initial=0.0):
            problems.add(where, "the stiffness is not diagonal; make the modes orthogonal first")
        w2 = np.diag(w2)
    if w2.shape != (twin.n,):
        problems.add(where, f"the stiffness is of {len(w2)} modes, the gauges' rows of {twin.n}")
    problems.raise_if_any()
    assert strain is not None and t is not None
    nt = len(t)
    step = (t[-1] - t[0]) / (nt - 1)
    base = 2.0 * np.pi / (nt * step)
    nh = (nt - 1) // 2 if harmonics is None else min(int(harmonics), (nt - 1) // 2)
    if limit is not None:
        nh = min(nh, int(limit * 2.0 * np.pi / base + 1e-9))
    p = twin.estimate(strain, t).p
    c = np.fft.rfft(p, axis=0)[: nh + 1] * (2.0 / nt)
    c[0] *= 0.5
    D = modal_damping(
        tuple(damping) if isinstance(damping, list | np.ndarray) else damping,
        np.sqrt(w2) / (2.0 * np.pi),
    )
    jw = base * np.arange(nh + 1)[:, None]
    f = (w2 - jw**2 + 1j * jw * D) * c
    return FourierLoads(base, float(t[0]), f[0].real, f[1:].real, -f[1:].imag, c)


@explained
def identify_loads(observer: Observer, time: Any, e: ArrayLike | None = None) -> Estimates:
    """Return unknown loads over time with their bands, from a whole record.

    Uses the smoothed record of the observer: the loads need not be periodic, gauges may drop out,
    the body may move. The result contains ``.loads`` and ``.load_band`` (standard deviation).

    Parameters
    ----------
    observer, time, e
        As for `Observer.run`.
    """
    return smooth(observer.run(time, e))


def external(
    f: ArrayLike, reduced: ReducedPart, observed_p: ArrayLike, time: ArrayLike, reference: Reference
) -> Array:
    """Return the external modal loads (nt, n), without inertia of the frame motion.

    ``f_ext = f + M_fr q_r'' - Q_v``: the loads from `identify_fourier` on a moving body contain the
    inertia of its rigid-body motion. Modal velocities are differences of the coordinates.

    Parameters
    ----------
    f : (nt, n) array_like
        Modal loads, kg^0.5 m/s2.
    reduced : ReducedPart
        Invariants.
    observed_p : (nt, n) array_like
        Modal coordinates.
    time : (nt,) array_like
        Instants, s.
    reference : Reference
        Motion of the frame.
    """
    t, p = np.asarray(time, dtype=np.float64), np.asarray(observed_p, dtype=np.float64)
    dp = np.gradient(p, t, axis=0)
    force = InertialForce(reduced.invariants)
    own = [force(reference.at(s), x, v) for s, x, v in zip(t, p, dp, strict=True)]
    return np.asarray(np.asarray(f, dtype=np.float64) - np.array(own))


def equivalent_load(M: Any, shapes: ArrayLike, f: ArrayLike) -> Array:
    """Return nodal loads ``F = M Phi f`` (nt, ndof) with the modal loads f.

    F is only the part of the true load that the modes represent: ``Phi^T F = f``.

    Parameters
    ----------
    M : (ndof, ndof) sparse array or array
        Mass matrix.
    shapes : (ndof, n) array_like
        Mass-normalised modes.
    f : (nt, n) array_like
        Modal loads.
    """
    return np.asarray((M @ (np.asarray(shapes) @ np.atleast_2d(f).T)).T)


def modal_loads(where: str, loads: Any, reduced: ReducedPart | None) -> Array:
    """Return the modal loads ``Phi^T L`` (n, na) of unit loads, given as such or by their place."""
    given = (loads,) if isinstance(loads, UnknownLoad) else loads
    if isinstance(given, Iterable) and not isinstance(given, np.ndarray | str):
        given = tuple(given)
        if given and all(isinstance(load, UnknownLoad) for load in given):
            if reduced is None:
                raise InputError(Problem(where, "loads by place need reduced="))
            given = np.hstack([load.columns(reduced)[0] for load in given])
    try:
        columns = np.asarray(given, dtype=np.float64)
        wrong = given is None or not columns.size or columns.ndim != 2
    except (TypeError, ValueError):
        wrong = True
    if wrong:
        text = f"of shape {given.shape}" if isinstance(given, np.ndarray) else repr(loads)
        raise InputError(
            Problem(
                where,
                f"loads is {text}, must be at least one UnknownLoad, such as "
                "[UnknownLoad('end', ('fz',))], or their modal loads (n, na)",
                path=("loads",),
            )
        )
    return columns


def place_loads(
    f: ArrayLike, loads: Any, reduced: ReducedPart | None = None
) -> tuple[Array, float]:
    """Return loads at known places from modal loads, ``a = (Phi^T L)^+ f``.

    Parameters
    ----------
    f : (nt, n) array_like
        Modal loads.
    loads : (n, na) array_like or sequence of UnknownLoad
        Modal loads ``Phi^T L`` of unit loads, or loads with their places.
    reduced : ReducedPart, optional
        The part, for loads by their place.

    Returns
    -------
    a : (nt, na) array
        N and N m.
    rest : float
        Share of f (root mean square) that such loads cannot cause.

    Raises
    ------
    InputError
        For more loads than modes, or loads that the modes cannot distinguish.
    """
    L = modal_loads("place_loads", loads, reduced)
    modal = np.atleast_2d(np.asarray(f, dtype=np.float64))
    if L.ndim != 2 or L.shape[0] != modal.shape[1]:
        raise InputError(
            Problem(
                "place_loads", f"loads have shape {L.shape}, the modal loads {modal.shape[1]} modes"
            )
        )
    size = np.linalg.norm(L, axis=0)
    values = np.linalg.svd(L / np.where(size > 0.0, size, 1.0), compute_uv=False)
    if L.shape[1] > L.shape[0] or values[-1] < 1e-8:
        raise InputError(
            Problem(
                "place_loads",
                f"{L.shape[0]} modes cannot distinguish {L.shape[1]} loads; give fewer, or take "
                "more modes and gauges",
            )
        )
    a = modal @ np.linalg.pinv(L).T
    whole = float(np.sqrt(np.mean(modal**2)))
    return a, float(np.sqrt(np.mean((modal - a @ L.T) ** 2)) / max(whole, 1e-300))


def locate_load(
    f: ArrayLike,
    reduced: ReducedPart,
    nodes: Sequence[str],
    components: Sequence[str] = ("fx", "fy", "fz"),
) -> list[tuple[str, float]]:
    """Return nodes, best first, with the share of the modal loads not explained by a load there.

    Parameters
    ----------
    f : (nt, n) array_like
        Modal loads.
    reduced : ReducedPart
        The part.
    nodes : sequence of str
        Candidate nodes of the load.
    components : sequence of str
        Components of the load.
    """
    rests = [
        (node, place_loads(f, [UnknownLoad(node, tuple(components))], reduced)[1]) for node in nodes
    ]
    return sorted(rests, key=lambda found: found[1])


@explained
def identify_payload(
    observed: Estimates, place: str, *, draws: int = 100, seed: int = 1
) -> tuple[float, float]:
    """Return the payload mass at a node of a body and its standard deviation, kg.

    Least squares of ``F = -m s`` over the record, with the estimated force F at the node, and the
    node's acceleration minus gravity s from the reference; the deviation comes from sampled
    histories (`sample_posterior`). Components that are not unknown loads are left out.

    Parameters
    ----------
    observed : Estimates
        Estimates from `Observer.run` with a reference and an unknown force at the node.
    place : str
        The node.
    draws, seed : int
        Number of histories, and seed of the random numbers.

    Raises
    ------
    InputError
        If there is no such load or no reference.
    """
    observer = observed.observer
    labels = observer.system.labels
    axes = [i for i, name in enumerate(("fx", "fy", "fz")) if f"{place}.{name}" in labels]
    problems = Problems()
    if observer.reference is None:
        problems.add(
            "identify_payload",
            "the observer has no reference, so the direction of the weight is unknown",
        )
    if not axes:
        problems.add("identify_payload", f"no unknown force fx, fy or fz at '{place}'")
    problems.raise_if_any()
    reduced = observer.system.reduced
    u = reduced.nodes[reduced.node(place)]
    s = []
    for t in observed.time:
        a, w, dw = STILL if observer.reference is None else observer.reference.at(float(t))
        s.append(a + np.cross(dw, u) + np.cross(w, np.cross(w, u)))
    felt = np.array(s)[:, axes]
    at = [labels.index(f"{place}.{('fx', 'fy', 'fz')[i]}") for i in axes]
    F = sample_posterior(observed, draws, seed=seed).loads[:, at]
    mass = -np.einsum("tcd,tc->d", F, felt) / np.sum(felt**2)
    return float(mass.mean()), float(mass.std(ddof=1))
