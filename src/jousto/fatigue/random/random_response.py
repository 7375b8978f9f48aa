"""Stress of a reduced part under random base acceleration or random forces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.base.ranking import ranking
from jousto.base.voigt import STRESS_COMPONENTS
from jousto.fatigue.random.spectral import (
    METHODS,
    Method,
    SpectralDamage,
    damage_of_moments,
    spectral_moments,
)
from jousto.reduction.reduced import ReducedPart

Complex = NDArray[np.complex128]
V = np.diag([1.0, 1.0, 1.0, 3.0, 3.0, 3.0])
V[:3, :3] -= 0.5 * (np.ones((3, 3)) - np.eye(3))
RIGID = 1e-6  # natural frequency over the highest one, below which a mode is a rigid motion


@described
@dataclass(frozen=True, eq=False)
class RandomResponse:
    """Spectral density of the modal coordinates of a part under random excitation.

    The density of the stress is ``S_ss = Sigma H S_ff H* Sigma^T``, with the stress modes Sigma,
    the transfer functions H of the modal coordinates and the density S_ff of the excitation.

    Attributes
    ----------
    reduced : ReducedPart
    frequency : (nf,) array
        Frequencies, Hz: the given ones and those added at resonances.
    transfer : (nf, n, m) complex array
        Transfer functions: modal coordinates per unit excitation.
    modal : (nf, n, n) complex array
        One-sided density of the modal coordinates.
    natural : (k,) array
        Natural frequencies of the supported part, Hz.
    damping : (k,) array
        Damping ratios.
    """

    reduced: ReducedPart
    frequency: Array
    transfer: Complex
    modal: Complex
    natural: Array
    damping: Array

    def sites(self, sites: Sequence[str] | str | None = None) -> tuple[tuple[str, ...], Array]:
        """Return labels and stress modes (ns, 6, n) of stress sites, of all if None."""
        stress = self.reduced.stress
        where = f"part '{self.reduced.name}'"
        if stress is None:
            raise InputError(
                Problem(where, "the part has no stress modes; add stress sites before reduction")
            )
        known = {label: i for i, label in enumerate(stress.labels)}
        wanted = tuple(known) if sites is None else (sites,) if isinstance(sites, str) else sites
        problems = Problems()
        for label in wanted:
            if label not in known:
                problems.add(where, f"no stress site '{label}'{suggest(label, known)}")
        problems.raise_if_any()
        return tuple(wanted), stress.modes[[known[label] for label in wanted]]

    def psd(
        self, criterion: str | ArrayLike = "von-mises", sites: Sequence[str] | str | None = None
    ) -> Array:
        """Return one-sided densities (ns, nf) of a stress, Pa^2/Hz.

        Parameters
        ----------
        criterion : str or (3,) array_like
            A component "s11".."s13" in the axes of the site; "von-mises", the equivalent stress of
            A. Preumont and V. Piefort (*J. Vib. Acoust.* 116 (1994) 245-248), a Gaussian process
            with the mean square of von Mises' stress at every frequency; or the normal of a plane,
            for its normal stress.
        sites : sequence of str, optional
            None takes all.
        """
        _, S = self.sites(sites)
        real = self.modal.real  # the density of one quantity depends on the symmetric part only
        if isinstance(criterion, str) and criterion == "von-mises":
            A = np.einsum("scj,cd,sdk->sjk", S, V, S)
            return np.asarray(np.maximum(np.einsum("sjk,fjk->sf", A, real), 0.0))
        if isinstance(criterion, str):
            if criterion not in STRESS_COMPONENTS:
                known = (*STRESS_COMPONENTS, "von-mises")
                raise InputError(
                    Problem(
                        "random response",
                        f"criterion is {criterion!r}, must be {', '.join(known)} or a normal (3,)"
                        f"{suggest(criterion, known)}",
                    )
                )
            rows = S[:, STRESS_COMPONENTS.index(criterion)]
        else:
            n = np.asarray(criterion, dtype=np.float64)
            if n.shape != (3,) or not np.linalg.norm(n) > 0.0:
                raise InputError(
                    Problem("random response", f"criterion is {criterion}, must be a normal (3,)")
                )
            n = n / np.linalg.norm(n)
            weights = [n[0] ** 2, n[1] ** 2, n[2] ** 2]
            weights += [2 * n[0] * n[1], 2 * n[1] * n[2], 2 * n[0] * n[2]]
            rows = np.einsum("c,scj->sj", weights, S)
        found = np.einsum("sj,fjk,sk->sf", rows, real, rows, optimize=True)
        return np.asarray(np.maximum(found, 0.0))

    def rms(
        self, criterion: str | ArrayLike = "von-mises", sites: Sequence[str] | str | None = None
    ) -> Array:
        """Return root mean squares (ns,) of a stress, Pa."""
        moments = spectral_moments(self.frequency, self.psd(criterion, sites), (0,))
        return np.asarray(np.sqrt(moments[:, 0]))

    def damage(
        self,
        sn: Any,
        *,
        criterion: str | ArrayLike = "von-mises",
        method: Method = "dirlik",
        sites: Sequence[str] | str | None = None,
    ) -> SpectralLife:
        """Return the damage per second at stress sites.

        Parameters
        ----------
        sn : SN
            S-N curve.
        criterion : str or (3,) array_like
            As for `psd`.
        method : {"dirlik", "narrow-band", "tovo-benasciutti", "wirsching-light"}
            See `amplitude_density` and `spectral_damage`.
        sites : sequence of str, optional
            Labels of the sites; None takes all.
        """
        if method not in METHODS:
            raise InputError(
                Problem("random response", f"method is {method!r}{suggest(method, METHODS)}")
            )
        labels, _ = self.sites(sites)
        moments = spectral_moments(self.frequency, self.psd(criterion, labels))
        rows = tuple(damage_of_moments(m, sn, method=method) for m in moments)
        name = criterion if isinstance(criterion, str) else f"normal stress on plane {criterion}"
        return SpectralLife(labels, rows, name, getattr(sn, "name", "") or str(sn))

    def synthesise(self, duration: float, *, rate: float, seed: int = 0) -> tuple[Array, Array]:
        """Return times (nt,) in s and modal coordinates (nt, n) of a random history.

        The coefficients of every frequency are normal random numbers with the covariance of the
        modal density, so that the history has its cross correlations too.
        """
        problems = Problems()
        problems.positive("synthesise", "duration", duration, "s")
        problems.positive("synthesise", "rate", rate, "1/s")
        if rate < 2.0 * self.frequency[-1]:
            problems.add(
                "synthesise",
                f"rate {rate:g} 1/s is below twice the highest frequency, "
                f"{self.frequency[-1]:g} Hz",
            )
        problems.raise_if_any()
        nt = max(2, round(duration * rate))
        grid = np.fft.rfftfreq(nt, 1.0 / rate)
        inside = (grid >= self.frequency[0]) & (grid <= self.frequency[-1]) & (grid > 0.0)
        n = self.modal.shape[1]
        rng = np.random.default_rng(seed)
        spectrum = np.zeros((len(grid), n), dtype=np.complex128)
        at = np.interp(grid[inside], self.frequency, np.arange(len(self.frequency)))
        low = np.minimum(at.astype(int), len(self.frequency) - 2)
        share = (at - low)[:, None, None]
        S = (1.0 - share) * self.modal[low] + share * self.modal[low + 1]
        values, vectors = np.linalg.eigh(S)
        normal = rng.normal(size=(len(S), n)) + 1j * rng.normal(size=(len(S), n))
        root = np.sqrt(np.maximum(values, 0.0))
        spectrum[inside] = np.einsum("fjk,fk->fj", vectors, root * normal)
        spectrum *= 0.5 * nt * math.sqrt(grid[1])
        return np.arange(nt) / rate, np.fft.irfft(spectrum, nt, axis=0)


@described
@dataclass(frozen=True, eq=False)
class SpectralLife(Tabular):
    """Damage per second of random stress at several sites.

    Attributes
    ----------
    labels : tuple of str
    rows : tuple of SpectralDamage
        Damage of each site.
    criterion, sn : str
        Names of the stress and of the S-N curve.
    """

    labels: tuple[str, ...]
    rows: tuple[SpectralDamage, ...]
    criterion: str
    sn: str

    @property
    def damage(self) -> Array:
        """Miner's sum per second, (ns,), 1/s."""
        return np.array([row.damage for row in self.rows])

    @property
    def life(self) -> Array:
        """Time to failure, s, (ns,)."""
        return np.array([row.life for row in self.rows])

    def table(self, rows: int = 10) -> str:
        """Return a table of the sites with the largest damage."""
        width = max(12, *(len(label) for label in self.labels))
        lines = [
            f"{self.rows[0].method if self.rows else ''} of {self.criterion}, {self.sn}",
            f"{'site':>{width}} {'rms':>9} {'cross.':>9} {'peaks':>9} {'irreg.':>7} {'damage':>11} "
            f"{'life':>11}",
            f"{'':>{width}} {'MPa':>9} {'1/s':>9} {'1/s':>9} {'':>7} {'1/s':>11} {'h':>11}",
        ]
        for i in ranking(self.damage, self.labels)[:rows]:
            r = self.rows[i]
            lines.append(
                f"{self.labels[i]:>{width}} {1e-6 * r.rms:9.3f} {r.crossings:9.2f} {r.peaks:9.2f} "
                f"{r.irregularity:7.3f} {r.damage:11.4g} {r.life / 3600:11.4g}"
            )
        return "\n".join(lines)

    def _csv(self) -> Rows:
        """Return the table of all sites."""
        head = ("site", "rms (Pa)", "crossings (1/s)", "peaks (1/s)", "damage (1/s)", "life (s)")
        rows = [
            (label, r.rms, r.crossings, r.peaks, r.damage, r.life)
            for label, r in zip(self.labels, self.rows, strict=True)
        ]
        return (*head, f"criterion: {self.criterion}"), rows

    def __str__(self) -> str:
        return self.table()


@explained
def random_response(
    reduced: ReducedPart,
    frequency: ArrayLike,
    psd: ArrayLike,
    *,
    base: Sequence[str] | str | None = None,
    direction: ArrayLike | None = None,
    forces: Sequence[tuple[str, ArrayLike]] | Mapping[str, ArrayLike] = (),
    damping: float | ArrayLike = 0.02,
) -> RandomResponse:
    """Return the response of a part to stationary random acceleration of its base, or to forces.

    The response is linear, about rest. The nodes of the base are clamped, or move together with
    the random acceleration.

    Parameters
    ----------
    reduced : ReducedPart
        Reduced part whose interfaces include the base, so that its modes represent the clamping.
    frequency : (nf,) array_like
        Frequencies of the density, Hz, ascending.
    psd : (nf,) or (nf, m, m) array_like
        One-sided density of the base acceleration, (m/s^2)^2/Hz, or of m forces, N^2/Hz
        (Hermitian). Linear between the frequencies, zero outside.
    base : str or sequence of str, optional
        Names of the nodes clamped to the base; None for a free part.
    direction : (3,) array_like, optional
        Direction of the base acceleration, part frame. None: the base is at rest and `forces` act.
    forces : sequence of (node name, (3,) direction), or mapping
        Directions of the forces on nodes, part frame.
    damping : float or (k,) array_like
        Damping ratio of the natural modes of the supported part.

    Raises
    ------
    InputError
        If acceleration and forces are both given or both missing, for unknown nodes, or an invalid
        density.

    Warns
    -----
    JoustoWarning
        If the highest natural frequency of the modes is inside or just above the band.
    """
    where = f"random response of '{reduced.name}'"
    names = () if base is None else (base,) if isinstance(base, str) else tuple(base)
    loads = list(forces.items()) if isinstance(forces, Mapping) else list(forces)
    problems = Problems()
    f = problems.array(where, "frequency", frequency, (None,))
    for name in (*names, *(node for node, _ in loads)):
        if len(reduced.node_sets.get(name, ())) != 1:
            problems.add(where, f"no node '{name}'{suggest(name, reduced.node_sets)}")
    if (direction is None) == (not loads):
        problems.add(where, "needs either the direction of the base acceleration or forces")
    if direction is not None and not names:
        problems.add(where, "direction= needs a base: base='name of a node'")
    problems.raise_if_any()
    assert f is not None

    M, K = _small_motion(reduced)
    C = np.concatenate([_motion(reduced, reduced.node(name)) for name in names] or [M[:0]])
    Z = scipy.linalg.null_space(C) if len(C) else np.eye(len(M))
    if direction is not None:
        a = np.asarray(direction, dtype=np.float64)
        if a.shape != (3,) or not np.linalg.norm(a) > 0.0:
            raise InputError(
                Problem(where, f"direction is {direction!r}, must be 3 numbers, not all zero")
            )
        B = -M[:, :3] @ (a / np.linalg.norm(a))[:, None]
    else:
        columns = []
        for node, way in loads:
            w = np.asarray(way, dtype=np.float64)
            if w.shape != (3,):
                raise InputError(Problem(where, f"force on '{node}' is {way!r}, must be 3 numbers"))
            columns.append(_motion(reduced, reduced.node(node))[:3].T @ w)
        B = np.stack(columns, axis=1)
    m = B.shape[1]
    S = np.asarray(psd)
    if S.shape == f.shape:
        S = S[:, None, None]
    problems = Problems()
    if S.shape != (len(f), m, m):
        problems.add(where, f"psd has shape {S.shape}, must be ({len(f)},) or ({len(f)}, {m}, {m})")
    elif len(f) < 2 or f[0] < 0.0 or np.any(np.diff(f) <= 0.0):
        problems.add(where, "frequency must be two or more ascending numbers")
    elif not np.all(np.isfinite(S)) or np.linalg.eigvalsh(S).min() < -1e-9 * np.abs(S).max():
        problems.add(where, "psd must be finite, Hermitian and not negative")
    problems.raise_if_any()

    squares, shapes = scipy.linalg.eigh(Z.T @ K @ Z, Z.T @ M @ Z)
    elastic = squares > (RIGID**2) * squares[-1]
    natural = np.sqrt(squares[elastic]) / (2.0 * np.pi)
    shapes = (Z @ shapes)[:, elastic]
    given = np.asarray(damping, dtype=np.float64)
    if given.shape not in ((), (1,), natural.shape):
        message = f"damping has shape {given.shape}, must be a number or one for each of"
        raise InputError(Problem(where, f"{message} {len(natural)} modes"))
    zeta = np.broadcast_to(given, natural.shape)
    if not np.all((zeta > 0.0) & (zeta < 1.0)):
        raise InputError(Problem(where, f"damping is {damping!r}, must be above 0 and below 1"))
    if natural[-1] < f[-1]:
        warn(
            where,
            f"the modes end at {natural[-1]:.4g} Hz, the spectrum at {f[-1]:.4g} Hz; reduce the "
            "part with more modes",
        )
    # add points at resonances, much closer than the half-power bandwidth
    grid = [f]
    for f0, z in zip(natural, zeta, strict=True):
        if f[0] < f0 < f[-1]:
            near = f0 * (1.0 + z * np.sinh(np.linspace(-5.0, 5.0, 161)) * 0.5)
            grid.append(near[(near > f[0]) & (near < f[-1])])
    fine = np.unique(np.concatenate(grid))
    w = 2.0 * np.pi * fine[:, None]
    w0 = 2.0 * np.pi * natural
    gain = 1.0 / (w0**2 - w**2 + 2j * zeta * w0 * w)
    transfer = np.einsum("jk,fk,km->fjm", shapes[6:], gain, shapes.T @ B, optimize=True)
    at = np.interp(fine, f, np.arange(len(f)))
    low = np.minimum(at.astype(int), len(f) - 2)
    share = (at - low)[:, None, None]
    level = (1.0 - share) * S[low] + share * S[low + 1]
    modal = np.einsum("fjm,fmn,fkn->fjk", transfer, level, transfer.conj(), optimize=True).astype(
        np.complex128
    )
    return RandomResponse(reduced, fine, transfer, modal, natural, np.array(zeta))


def _small_motion(reduced: ReducedPart) -> tuple[Array, Array]:
    """Return mass and stiffness (6 + n, 6 + n) of translation, rotation and modes about rest."""
    i, n = reduced.invariants, reduced.n
    M = np.zeros((6 + n, 6 + n))
    c = i.first_moment
    M[:3, :3] = i.mass * np.eye(3)
    tilde = np.array([[0.0, -c[2], c[1]], [c[2], 0.0, -c[0]], [-c[1], c[0], 0.0]])
    M[3:6, :3], M[:3, 3:6] = tilde, tilde.T
    M[3:6, 3:6] = i.I7
    M[:3, 6:], M[6:, :3] = i.I3, i.I3.T
    M[3:6, 6:], M[6:, 3:6] = i.I4, i.I4.T
    M[6:, 6:] = np.eye(n)
    K = np.zeros_like(M)
    K[6:, 6:] = np.diag(reduced.stiffness)
    return M, K


def _motion(reduced: ReducedPart, node: int) -> Array:
    """Return the Jacobian (3 or 6, 6 + n) of the translation and any rotation of a node."""
    x = reduced.nodes[node]
    tilde = np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])
    rows = np.concatenate([np.eye(3), -tilde, reduced.modes[node]], axis=1)
    turn = reduced.rotation(node)
    if turn is None:
        return rows
    return np.concatenate(
        [rows, np.concatenate([np.zeros((3, 3)), np.eye(3), turn], axis=1)], axis=0
    )
