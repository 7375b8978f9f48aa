"""Placement of gauges for the smallest variance of modes or of stress at hot spots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.base.object_repr import described
from jousto.base.ranking import largest
from jousto.measurement.twin.motion.system import as_rows
from jousto.measurement.twin.reconstruction import NOISE, WEIGH
from jousto.measurement.twin.signals import LARGEST, read_noise
from jousto.reduction.reduced import ReducedPart

SWEEPS = 50


@described
@dataclass(frozen=True, eq=False)
class Placement:
    """Gauges selected from candidates.

    Attributes
    ----------
    names : tuple of str
        Names of the selected candidates, the most informative first.
    index : (ng,) int array
        Indices of the selected candidates.
    rows : (ng, n) array
        Strain of each mode at the gauges.
    criterion : str
        "D" or "I".
    value : float
        "D": ``log det(B^T Rn^-1 B + G^-1)``, larger is better; "I": root mean square of the
        standard deviation at the hot spots, Pa, smaller is better.
    history : tuple of float
        Value with the first gauge, the first two gauges and so on of the greedy selection, then
        after the exchanges.
    condition : float
        Condition number of the rows.
    """

    names: tuple[str, ...]
    index: NDArray[np.intp]
    rows: Array
    criterion: str
    value: float
    history: tuple[float, ...]
    condition: float

    def __str__(self) -> str:
        what = (
            f"log det = {self.value:.4g}"
            if self.criterion == "D"
            else f"standard deviation at the hot spots {self.value / 1e6:.4g} MPa (rms)"
        )
        return (
            f"{count(len(self.names), 'gauge')}, {self.criterion}-optimal: {what}, condition "
            f"{self.condition:.3g}\n" + "\n".join(f"  {name}" for name in self.names)
        )


@explained
def place_gauges(
    candidates: Any,
    count: int,
    *,
    criterion: str = "D",
    hot: ArrayLike | Any = None,
    noise: ArrayLike = NOISE,
    prior: ArrayLike | None = None,
    trajectory: ArrayLike | None = None,
    names: Sequence[str] = (),
    positions: ArrayLike | None = None,
    exclude: Any = (),
    separation: float = 0.0,
) -> Placement:
    """Select gauges from candidates for the smallest variance of modes or hot spots.

    "D" maximises ``log det(B^T Rn^-1 B + G^-1)``, "I" minimises ``trace(S_hot P S_hot^T)``, ``P =
    (B^T Rn^-1 B + G^-1)^-1``: better for stress monitoring. Gauges are added one by one, then
    exchanged for candidates as long as the criterion improves (Fedorov 1972). Of equally good
    candidates, for example symmetric ones, the first by name is selected.

    Parameters
    ----------
    candidates : ReducedPart, (nc, n) array_like or sequence of Gauge
        Rows of strain per mode, such as ``gauge_rows(gauges)``; for a part, its stress sites are
        candidates, with gauges along the first axis of the site.
    count : int
        Number of gauges.
    criterion : {"D", "I"}
        Criterion, see above.
    hot : (k, n) array_like or StressModes
        Stress of each mode at the hot spots, Pa, for "I": rows of components, or stress modes with
        all their components.
    noise : float or (nc,) array_like
        Standard deviation of the candidates, m/m.
    prior : float, (n,) or (n, n) array_like, optional
        Prior covariance as in `Reconstruction`.
    trajectory : (nt, n) array_like, optional
        Modal coordinates of a run, ``run.coordinates(body)[:, 7:]``: its mean square over the whole
        motion becomes the prior, so that large motions have more weight. Not together with `prior`.
    names : sequence of str, optional
        Names of the candidates.
    positions : (nc, 3) array_like, optional
        Positions of candidates, m; known for a part and for gauges with a position.
    exclude : sequence of InBox, InSphere, InCylinder or tuple (point, radius)
        Zones without gauges: welds, hot surfaces, inaccessible places.
    separation : float
        Smallest distance between two gauges, m.

    Raises
    ------
    InputError
        For inconsistent arguments, or too few candidates outside the zones.
    """
    problems = Problems()
    where = "place_gauges"
    B, known, places = _candidates(candidates)
    labels = tuple(names) or known
    if positions is not None:
        places = problems.array(where, "positions", positions, (len(B), 3))
    if criterion not in ("D", "I"):
        problems.add(where, f"criterion is {criterion!r}, must be 'D' or 'I'")
    n = B.shape[1]
    S = None
    if criterion == "I":
        raw = getattr(hot, "modes", hot)
        if raw is None:
            problems.add(where, "criterion 'I' needs hot=, the stress modes of the hot spots")
        else:
            S = problems.array(
                where, "hot", np.asarray(raw).reshape(-1, np.shape(raw)[-1]), (None, n)
            )
    if len(labels) != len(B):
        problems.add(where, f"{len(labels)} names for {len(B)} candidates")
    if (exclude or separation) and places is None:
        problems.add(where, "zones and separation need positions= of the candidates")
    wanted: Any = count
    if isinstance(wanted, bool) or not isinstance(wanted, int | np.integer) or wanted < 1:
        problems.add(where, f"count is {count!r}, must be a whole number, 1 or more")
    R = read_noise(problems, where, "noise", noise, len(B), "m/m", LARGEST)
    if prior is not None and trajectory is not None:
        problems.add(where, "give prior or trajectory, not both")
    G = None
    if trajectory is not None:
        p = problems.array(where, "trajectory", trajectory, (None, n))
        if p is not None and len(p):
            G = p.T @ p / len(p)
            G += 1e-9 * np.trace(G) / n * np.eye(n)
    elif prior is not None:
        G = read_noise(problems, where, "prior", prior, n, "kg^0.5 m", np.inf)
    problems.raise_if_any()
    assert R is not None
    if G is None and count < n:
        raise InputError(
            Problem(
                where,
                f"{count} gauges cannot distinguish {n} modes; take more, {WEIGH}, or give a prior "
                "or the trajectory of a run",
            )
        )
    free = np.ones(len(B), dtype=bool)
    for zone in exclude:
        free[_is_in_zone(zone, places)] = False
    sd = np.sqrt(np.diag(R))
    W = B / sd[:, None]
    search = _Search(W, G, S, places, separation, free, labels)
    chosen = search.greedy(int(count))
    history = [search.value(chosen[: k + 1]) for k in range(len(chosen))]
    chosen = search.exchange(chosen)
    history.append(search.value(chosen))
    rows = B[chosen]
    s = la.svdvals(rows / sd[chosen, None])
    condition = float(s[0] / s[-1]) if len(rows) >= n and s[-1] > 1e-12 * s[0] else float("inf")
    values = history if criterion == "D" else [float(np.sqrt(-x / len(S))) for x in history]  # type: ignore[arg-type]
    return Placement(
        tuple(labels[i] for i in chosen),
        np.array(chosen, dtype=np.intp),
        rows,
        criterion,
        values[-1],
        tuple(values),
        condition,
    )


class _Search:
    """Greedy selection and exchange of candidates; a larger value is better."""

    def __init__(
        self,
        W: Array,
        G: Array | None,
        S: Array | None,
        places: Array | None,
        separation: float,
        free: NDArray[np.bool_],
        labels: tuple[str, ...],
    ) -> None:
        self.W, self.S, self.places, self.labels = W, S, places, labels
        self.separation, self.free = separation, free
        scale = float(np.mean(np.einsum("ij,ij->i", W, W))) or 1.0
        # weak prior: the first gauges do not determine all modes
        self.base = np.linalg.inv(G) if G is not None else 1e-9 * scale * np.eye(W.shape[1])

    def information(self, chosen: list[int]) -> Array:
        rows = self.W[chosen]
        return np.asarray(self.base + rows.T @ rows)

    def value(self, chosen: list[int]) -> float:
        A = self.information(chosen)
        if self.S is None:
            return float(np.linalg.slogdet(A)[1])
        return -float(np.einsum("ij,ji->", self.S, np.linalg.solve(A, self.S.T)))

    def gains(self, A: Array) -> Array:
        """Return the increase of the value by each candidate for information matrix A."""
        P = np.linalg.inv(A)
        WP = self.W @ P
        h = np.einsum("ij,ij->i", WP, self.W)
        if self.S is None:
            return np.asarray(np.log1p(h))
        return np.asarray(np.sum((WP @ self.S.T) ** 2, axis=1) / (1.0 + h))

    def allowed(self, chosen: list[int]) -> NDArray[np.bool_]:
        good = self.free.copy()
        good[chosen] = False
        if self.separation > 0.0 and self.places is not None:
            for i in chosen:
                good &= np.linalg.norm(self.places - self.places[i], axis=1) >= self.separation
        return good

    def greedy(self, count: int) -> list[int]:
        chosen: list[int] = []
        for k in range(count):
            good = self.allowed(chosen)
            if not good.any():
                raise InputError(
                    Problem(
                        "place_gauges",
                        f"only {k} of {count} gauges could be placed: {int(self.free.sum())} of "
                        f"{len(self.W)} candidates are outside the zones, {self.separation:g} m "
                        "apart",
                    )
                )
            gains = np.where(good, self.gains(self.information(chosen)), -np.inf)
            chosen.append(largest(gains, self.labels))
        return chosen

    def exchange(self, chosen: list[int]) -> list[int]:
        for _ in range(SWEEPS):
            better = False
            for place in range(len(chosen)):
                rest = chosen[:place] + chosen[place + 1 :]
                good = self.allowed(rest)
                gains = np.where(good, self.gains(self.information(rest)), -np.inf)
                best = largest(gains, self.labels)
                if best != chosen[place] and gains[best] > gains[chosen[place]] * (1 + 1e-9):
                    chosen = [*chosen[:place], best, *chosen[place + 1 :]]
                    better = True
            if not better:
                break
        return chosen


def _candidates(candidates: Any) -> tuple[Array, tuple[str, ...], Array | None]:
    """Return rows, names and (if known) positions of the candidates."""
    if isinstance(candidates, ReducedPart):
        stress = candidates.stress
        if stress is None or stress.elasticity is None:
            raise InputError(
                Problem(
                    "place_gauges", "the part has no stress data, or no modulus; give rows instead"
                )
            )
        E, nu = stress.elasticity.T
        direct = stress.modes[:, :3]
        rows = (direct[:, 0] - nu[:, None] * (direct[:, 1] + direct[:, 2])) / E[:, None]
        return rows, stress.labels, stress.positions
    n = np.shape(candidates)[-1] if isinstance(candidates, np.ndarray) else 0
    if not n and not isinstance(candidates, np.ndarray):
        items = tuple(candidates)
        if items and not hasattr(items[0], "rows"):
            n = len(items[0])
        candidates = items
    rows, names = as_rows(candidates, n)
    places = None
    if not isinstance(candidates, np.ndarray) and len(candidates) == len(rows):
        found: list[Any] = [getattr(x, "position", None) for x in candidates]
        if all(np.shape(x) == (3,) for x in found):
            places = np.array(found, dtype=np.float64)
    return rows, names, places


def _is_in_zone(zone: Any, places: Array | None) -> NDArray[np.intp]:
    """Return the candidates inside a zone."""
    assert places is not None
    if hasattr(zone, "of"):
        return np.asarray(zone.of(places), dtype=np.intp)
    point, radius = zone
    return np.flatnonzero(np.linalg.norm(places - np.asarray(point), axis=1) <= float(radius))
