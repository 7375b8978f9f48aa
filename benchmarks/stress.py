"""Stress fields: bytes a second against a plain copy in the same run, and values a second.

One frame of 50,000 places and 20 modes reads every stress mode once: it can be no faster than the
memory. Many instants at a time reuse the modes in the cache: there arithmetic is the limit.

    python benchmarks/stress.py [--places 50000] [--modes 20] [--full]

Times are processor time of this thread, least of several repetitions, so that other work on the
machine counts little. --full runs the envelope over 1e5 places x 1e5 instants as well.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

import jousto as jo
from jousto.recovery.fields.criteria import von_mises
from jousto.reduction.fields.stress import StressModes


def least(work: Callable[[], object], seconds: float = 1.0, most: int = 60) -> float:
    """Return the least processor time of some repetitions, s."""
    best, spent = np.inf, 0.0
    for _ in range(most):
        start = time.thread_time()
        work()
        took = time.thread_time() - start
        best, spent = min(best, took), spent + took
        if spent > seconds:
            break
    return best


def synthetic(ns: int, nt: int, n: int) -> jo.recovery.StressField:
    """A field of random modes and coordinates."""
    rng = np.random.default_rng(1)
    eye = np.broadcast_to(np.eye(3), (ns, 3, 3))
    S = rng.standard_normal((ns, 6, n))
    modes = StressModes(tuple(f"n{i}" for i in range(ns)), np.zeros((ns, 3)), eye, S)
    return jo.recovery.field_from(modes, rng.standard_normal((nt, n)), np.arange(nt, dtype=float))


def frame(ns: int, n: int) -> None:
    field = synthetic(ns, 400, n)
    S = np.ascontiguousarray(field.S)
    to = np.empty_like(S)
    copy = least(lambda: np.copyto(to, S))
    rate = 2 * S.nbytes / copy / 1e9
    print(f"one frame, {ns} places x 6 x {n} modes ({S.nbytes / 1e6:.0f} MB of modes)")
    print(f"  copy of the modes         {1e3 * copy:8.3f} ms {rate:8.1f} GB/s read and written")
    flat, p = S.reshape(6 * ns, n), field.p[0]
    plain = least(lambda: von_mises((flat @ p).reshape(ns, 6)))
    print(f"  NumPy, s = S p, von Mises {1e3 * plain:8.3f} ms {S.nbytes / plain / 1e9:8.1f} GB/s")
    for criterion in ("von-mises", "signed-von-mises", "principal-1"):
        ((_, _, kernel),) = field._kernels(criterion)
        out = np.empty((1, ns))
        took = least(lambda k=kernel, o=out: k.values(field.p[:1], out=o))  # type: ignore[misc]
        read = kernel.packed.nbytes + out.nbytes
        print(
            f"  jousto, {criterion:18s}{1e3 * took:8.3f} ms {read / took / 1e9:8.1f} GB/s of "
            f"{read / 1e6:.0f} MB, {read / took / 1e9 / rate:.2f} of the copy"
        )
    print("many instants, the modes stay in the cache")
    some = field.take(np.arange(4000))
    for criterion in ("von-mises", "signed-von-mises", "principal-1", "max-shear", "s11"):
        took = least(lambda c=criterion: some.envelope(c))  # type: ignore[misc]
        each = took / (some.ns * some.nt)
        flops = 2 * n * (1 if criterion == "s11" else 5 if criterion == "von-mises" else 6)
        print(
            f"  {criterion:20s}{1e9 * each:8.2f} ns a value, {flops / each / 1e9:6.1f} GFlop/s "
            f"of the product, 1e5 x 1e5 in {1e10 * each:6.0f} s"
        )


def whole(n: int) -> None:
    field = synthetic(100_000, 100_000, n)
    start = time.thread_time()
    envelope = field.envelope("von-mises")
    took = time.thread_time() - start
    print(f"envelope of 1e5 places x 1e5 instants: {took:.1f} s; {envelope}")


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--places", type=int, default=50_000)
    arguments.add_argument("--modes", type=int, default=20)
    arguments.add_argument("--full", action="store_true")
    given = arguments.parse_args()
    frame(given.places, given.modes)
    if given.full:
        whole(given.modes)


if __name__ == "__main__":
    main()
