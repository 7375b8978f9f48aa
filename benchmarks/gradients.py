"""What a gradient costs in runs beside central differences, and how exact both are.

A chain of eight links on hinges with springs: parameters are the stiffnesses, the outcome is where
its end is after a second. Process time of one thread. Run: python benchmarks/gradients.py
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import jousto as jo

Array = NDArray[np.float64]

LINKS = 8
RUN = {"t_end": 1.0, "solver": jo.RK4(1e-3), "output_step": 1e-2}
OUTCOME = "last(end.x)"
TIMES = 5


def chain(**stiffness: float) -> jo.Mechanism:
    """Return the chain, whose hinges have springs of 20 N m/rad where none is given."""
    items: list[object] = [jo.Gravity((0, -9.81, 0))]
    last = jo.ground["origin"]
    for i in range(LINKS):
        link = jo.RigidBody(
            f"link{i}",
            1.0,
            (1e-3, 2e-2, 2e-2),
            position=(0.5 * i + 0.25, 0, 0),
            markers={"a": (-0.25, 0, 0), "b": (0.25, 0, 0)},
        )
        hinge = jo.Revolute(f"hinge{i}", last, link["a"], (0, 0, 1))
        k = stiffness.get(f"k{i}", 20.0)
        items += [link, hinge, jo.Spring(f"spring{i}", hinge.angle, k, damping=0.5)]
        last = link["b"]
    return jo.Mechanism(*items, jo.PositionSensor("end", last))


def study_of(count: int) -> jo.design.Study:
    """Return a study of the first springs; a new one remembers nothing."""
    names = [f"k{i}" for i in range(count)]
    return jo.study(chain, [jo.Parameter(name, 20.0) for name in names], OUTCOME, **RUN)


def spent(work: Callable[[], object]) -> float:
    """Return the least process time of some work, s."""
    found = []
    for _ in range(TIMES):
        start = time.process_time()
        work()
        found.append(time.process_time() - start)
    return min(found)


def differences(study: jo.design.Study, share: float) -> Array:
    """Return central differences by all parameters, with steps of a share of each."""
    x = np.asarray(study.nominal)
    moves = np.diag(share * x)
    ends = study(np.concatenate([x + moves, x - moves]))[:, 0]
    slopes: Array = (ends[: len(x)] - ends[len(x) :]) / (2.0 * share * x)
    return slopes


def costs() -> None:
    """Print gradients in runs of the machine by itself."""
    moved = iter(np.linspace(19.0, 21.0, 10_000))
    alone = study_of(1)
    alone([20.5])
    run = spent(lambda: alone([next(moved)]))
    print(f"one point of a study: {1e3 * run:.2f} ms; in such points:")
    print("parameters  complex step  with its check  central differences")
    for count in (1, 2, 4, 8):

        def exact(count: int = count, check: bool = False) -> object:
            return jo.design.gradient(study_of(count), check=check)

        start = spent(lambda count=count: study_of(count))
        plain, checked = (
            spent(lambda check=check, exact=exact: exact(check=check)) for check in (False, True)
        )
        central = spent(lambda count=count: differences(study_of(count), 1e-4))
        row = [(t - start) / run for t in (plain, checked, central)]
        print(f"{count:10d}  {row[0]:12.1f}  {row[1]:14.1f}  {row[2]:19.1f}")


def errors() -> None:
    """Print the error of central differences by their step, relative to the largest derivative."""
    study = study_of(LINKS)
    exact = jo.design.gradient(study).jacobian[0]
    size = np.abs(exact).max()
    share = 1e-2
    best = (4.0 * differences(study, share / 2) - differences(study, share)) / 3.0
    finer = (4.0 * differences(study, share / 4) - differences(study, share / 2)) / 3.0
    sixth = (16.0 * finer - best) / 15.0  # Richardson: errors of the sixth order
    print(f"complex step: {np.abs(exact - sixth).max() / size:.1e} from differences of sixth order")
    for power in range(1, 12):
        error = np.abs(differences(study, 10.0**-power) - exact).max() / size
        print(f"step 1e-{power:02d} of the stiffness: {error:.1e}")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    costs()
    errors()
