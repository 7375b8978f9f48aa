"""The rigid chain with revolute joints in Pinocchio: forward dynamics in joint angles."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import jousto as jo
from cases import GRAVITY, LENGTH
from machines import CENTER, INERTIA, MASS, RigidChain, rigid_chain

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """Time of one evaluation of the accelerations and how far apart they are."""

    ours: float  # us, accelerations and reactions
    theirs: float  # us, accelerations
    apart: float  # largest difference of an angular acceleration, relative to the largest


def model(case: RigidChain) -> Any:
    tree = pin.Model()
    tree.gravity.linear = np.array(GRAVITY)
    joint = 0
    for k in range(case.bodies):
        kind = pin.JointModelRZ() if k % 2 == 0 else pin.JointModelRY()
        place = pin.SE3(np.eye(3), np.array([LENGTH if k else 0.0, 0.0, 0.0]))
        joint = tree.addJoint(joint, kind, place, f"joint{k + 1}")
        body = pin.Inertia(MASS, np.array(CENTER), np.diag(INERTIA))
        tree.appendBodyToJoint(joint, body, pin.SE3.Identity())
    return tree


def least(call: Any, repeats: int, count: int) -> float:
    """Microseconds of one call."""
    best = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        for _ in range(count):
            call()
        best = min(best, time.process_time() - begin)
    return 1e6 * best / count


def compare(case: RigidChain) -> Comparison:
    """Accelerations of both codes at the same bent and moving chain."""
    tree = model(case)
    data = tree.createData()
    rng = np.random.default_rng(1)
    q, v = 0.1 * rng.normal(size=case.bodies), rng.normal(size=case.bodies)
    tau = np.zeros(case.bodies)
    acceleration = pin.aba(tree, data, q, v, tau).copy()
    pin.forwardKinematics(tree, data, q, v, acceleration)
    engine = jo.model.Engine(jo.compile(rigid_chain(case)))
    theirs = np.zeros((case.bodies, 3))
    for k, body in enumerate(engine.model.bodies):
        place, twist = data.oMi[k + 1], data.v[k + 1]
        x, y, z, w = pin.Quaternion(place.rotation).coeffs()
        engine.q[body.iq : body.iq + 7] = [*place.translation, w, x, y, z]
        engine.v[body.iv : body.iv + 3] = place.rotation @ twist.linear
        engine.v[body.iv + 3 : body.iv + 6] = twist.angular
        theirs[k] = data.a[k + 1].angular
    a, _ = engine.accelerations()
    ours = a.reshape(case.bodies, 6)[:, 3:]
    apart = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
    count = max(10, 10_000 // case.bodies)
    return Comparison(
        ours=least(engine.accelerations, 15, count),
        theirs=least(lambda: pin.aba(tree, data, q, v, tau), 15, count),
        apart=apart,
    )
