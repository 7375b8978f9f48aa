"""Elastic joints and a flexible link among rigid ones: microseconds of a step in both cores.

    .venv/bin/python benchmarks/elastic_joints.py [quick]

A chain of hinged rigid links, each joint with a motor behind an elastic gear; then a chain of six
links of which the third one or all are flexible. One step of classical Runge-Kutta and one of
ROS2; the models take turns in one run, least of many, processor time. Printed as it stands in
docs/benchmarks-trees.md.
"""

from __future__ import annotations

import sys
import warnings
from typing import Any

import jousto as jo
from cases import GRAVITY, LENGTH, beam
from machines import CENTER, INERTIA, MASS
from ports import costs

Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
METHODS = (("rk4", "RK4"), ("ros2", "ROS2"))


def chain(
    count: int, elastic: bool = True, flexible: tuple[int, ...] = (), modes: int = 0
) -> jo.Mechanism:
    """Return a chain of hinged links with elastic joints, or with flexible links."""
    items: list[Any] = []
    before: Any = jo.ground.at((0, 0, 0))
    for k in range(count):
        place = (LENGTH * k, 0, 0)
        if k in flexible:
            link: Any = jo.FlexibleBody(f"link{k}", beam(modes), position=place)
            start, end = link["start"], link["end"]
        else:
            link = jo.RigidBody(f"link{k}", MASS, INERTIA, center=CENTER, position=place)
            start, end = link.at((0, 0, 0)), link.at((LENGTH, 0, 0))
        pin = jo.Revolute(f"pin{k}", before, start, Y if k % 2 else Z)
        items += [link, pin]
        if elastic:
            gear = {"stiffness": 2e3, "damping": 1.0}
            items.append(jo.mechanism.ElasticJoint(f"pin{k}", pin.angle, 100, 1e-5, **gear))
        before = end
    return jo.Mechanism(*items, jo.Gravity(GRAVITY))


def elastic_chains(rounds: int, counts: tuple[int, ...]) -> None:
    print("| elastic joints | method | joint | maximal | ratio | rigid joints |")
    print("|---|---|---|---|---|---|")
    for count in counts:
        whole, bare = chain(count), jo.compile(chain(count, elastic=False), core="joint")
        pair = [jo.compile(whole, core=core) for core in ("joint", "maximal")]
        for method, name in METHODS:
            joint, maximal, rigid = costs([*pair, bare], method, rounds)
            ratio = maximal / joint
            print(f"| {count} | {name} | {joint:.1f} | {maximal:.1f} | {ratio:.1f} | {rigid:.1f} |")


def flexible_links(rounds: int, sizes: tuple[int, ...]) -> None:
    """One flexible link of six, then six; the rigid chain and one free flexible link."""
    print("| modes | method | one: joint | maximal | all six: maximal | none: joint | one alone |")
    print("|---|---|---|---|---|---|---|")
    rigid = jo.compile(chain(6, elastic=False), core="joint")
    for modes in sizes:
        one, every = (chain(6, False, which, modes) for which in ((2,), tuple(range(6))))
        models = [jo.compile(one, core=core) for core in ("joint", "maximal")]
        models += [jo.compile(every), rigid]
        with warnings.catch_warnings():  # it moves freely
            warnings.simplefilter("ignore", jo.JoustoWarning)
            alone = jo.Mechanism(jo.FlexibleBody("link", beam(modes)), jo.Gravity(GRAVITY))
        models.append(jo.compile(alone))
        for method, name in METHODS:
            times = costs(models, method, rounds)
            print(f"| {modes} | {name} | {' | '.join(f'{x:.1f}' for x in times)} |")


def main() -> None:
    short = "short" in sys.argv
    rounds = 2 if short else 20 if "quick" in sys.argv else 100
    elastic_chains(rounds, (6,) if short else (6, 12, 24, 48))
    print()
    flexible_links(rounds, (4,) if short else (4, 10, 20))


if __name__ == "__main__":
    main()
