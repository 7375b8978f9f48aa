"""A walk of a humanoid with feet on both sides of its trunk: angles of its joints over time.

The centre of mass follows the linear inverted pendulum c - (h/g) c'' = p for the zero-moment point
p under the feet, solved for the whole walk as one band matrix (S. Kagami et al., A fast dynamically
equilibrated walking trajectory generation method, Autonomous Robots 12 (2002), 71-82). The
difference to the zero-moment point of all links moves it again, as in the second stage of
S. Kajita et al., Biped walking pattern generation by preview control, ICRA 2003.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import solve_banded

import jousto as jo

G, DT = 9.81, 0.04  # m/s2, s between the points of the plan
STEPS, STRIDE, LIFT = 6, 0.1, 0.04  # number of steps, m
SINGLE, DOUBLE, BEGIN, END = 0.64, 0.32, 0.8, 1.2  # s on one foot, on both, before and after
SIDES = ("right", "left")
LEG = ("hip_x", "hip_z", "hip_y", "knee", "ankle_y", "ankle_x")
MIDDLE = 0.035  # m from the ankle to the middle of a foot
BEND = 0.35  # rad of hip and ankle


def step(x: Any) -> Any:
    """A smooth step from 0 to 1."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


def gait(home: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, feet (instants, side, 3) and zero-moment point (instants, 2) of the walk, m."""
    period = SINGLE + DOUBLE
    t = np.arange(0.0, BEGIN + STEPS * period + END + DT / 2, DT)
    feet = np.tile(home, (len(t), 1, 1))
    middle = home.mean(axis=0)[:2]
    p = np.tile(middle + (MIDDLE, 0.0), (len(t), 1))
    where = home.copy()
    point = p[0].copy()
    for i in range(STEPS):
        swing, stance = i % 2, 1 - i % 2
        start = BEGIN + i * period
        under = where[stance, :2] + (MIDDLE, 0.0)
        p[t >= start] = point + step((t[t >= start, None] - start) / DOUBLE) * (under - point)
        s = (t - start - DOUBLE) / SINGLE
        far = STRIDE * (0.5 if i in (0, STEPS - 1) else 1.0)
        feet[:, swing, 0] += far * step(s)
        feet[:, swing, 2] += LIFT * np.where((s > 0) & (s < 1), np.sin(np.pi * step(s)) ** 2, 0)
        where[swing, 0] += far
        point = under
    last = where[:, :2].mean(axis=0) + (MIDDLE, 0.0)
    start = BEGIN + STEPS * period
    p[t >= start] = point + step((t[t >= start, None] - start) / DOUBLE) * (last - point)
    return t, feet, p


def pendulum(p: np.ndarray, height: float) -> np.ndarray:
    """Centre of mass (instants, 2) of the zero-moment point p, at rest at both ends, m."""
    k = height / G / DT**2
    band = np.array([np.full(len(p), -k), np.full(len(p), 1 + 2 * k), np.full(len(p), -k)])
    band[1, [0, -1]] = 1 + k  # no speed at the ends
    return np.asarray(solve_banded((1, 1), band, p))


class Plan:
    """Joint angles of a walk: both legs below an upright trunk by inverse kinematics."""

    def __init__(self, robot: Any) -> None:
        self.tree = jo.robots.Tree(robot)
        names = list(self.tree.velocities)
        self.legs = [[names.index(f"{n}_{side}.angle") for n in LEG] for side in SIDES]
        links = self.tree.forward_kinematics(self.tree.initial)
        every = jo.robots.mechanism(robot).bodies
        bodies = [x for x in every if isinstance(x, jo.RigidBody) and x.name in links]
        self.links = [(one.name, np.array(one.center)) for one in bodies]
        self.masses = np.array([one.mass for one in bodies])
        self.q = np.array(self.tree.initial)
        sole = self.feet(self.q)[0, 2]
        for leg in self.legs:
            self.q[[i + 1 for i in leg]] = [0, 0, -BEND, -2 * BEND, -BEND, 0]
        self.q[2] += sole - self.feet(self.q)[0, 2]

    def feet(self, q: np.ndarray) -> np.ndarray:
        """Origins of both feet (2, 3), m."""
        return np.array([self.tree.pose(f"foot_{side}", q).r for side in SIDES])

    def centres(self, q: np.ndarray) -> np.ndarray:
        """Centres of mass of the links (n, 3), m."""
        poses = self.tree.forward_kinematics(q)
        return np.array([poses[name].r + poses[name].A @ c for name, c in self.links])

    def reach(self, feet: np.ndarray, c: np.ndarray) -> np.ndarray:
        """Positions of the tree (nq,) with level feet, and the centre of mass above c: Newton."""
        q = self.q
        for _ in range(2):
            q[:2] += c - (self.masses @ self.centres(q))[:2] / self.masses.sum()
            for leg, side, foot in zip(self.legs, SIDES, feet, strict=True):
                pose, J = self.tree.pose(f"foot_{side}", q), self.tree.jacobian(f"foot_{side}", q)
                A = pose.A
                turn = 0.5 * np.array([A[1, 2] - A[2, 1], A[2, 0] - A[0, 2], A[0, 1] - A[1, 0]])
                q[[i + 1 for i in leg]] += np.linalg.solve(J[:, leg], [*(foot - pose.r), *turn])
        return q.copy()

    def walk(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, positions (instants, nq) and zero-moment point (instants, 2) of the walk."""
        t, feet, p = gait(self.feet(self.q))
        height = (self.masses @ self.centres(self.q))[2] / self.masses.sum()
        c, start = pendulum(p, height), self.q.copy()
        for correct in (True, True, False):
            self.q = start.copy()
            q = np.array([self.reach(*one) for one in zip(feet, c, strict=True)])
            if correct:
                c += pendulum(p - self.zero_moment_point(q), height)
        return t, q, p

    def zero_moment_point(self, q: np.ndarray) -> np.ndarray:
        """Zero-moment point (instants, 2) of the links as points: sum m ((z'' + g) x - z x'')."""
        x = np.array([self.centres(one) for one in q])
        a = np.zeros_like(x)
        a[1:-1] = np.diff(x, 2, axis=0) / DT**2
        a[..., 2] += G
        m = self.masses[:, None]
        top = (m * (a[..., 2:] * x[..., :2] - x[..., 2:] * a[..., :2])).sum(axis=1)
        return top / (m * a[..., 2:]).sum(axis=1)
