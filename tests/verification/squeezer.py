"""Andrews' squeezer: seven bars in a plane, three loops, one spring, one motor.

Data and solution: Hairer and Wanner, *Solving Ordinary Differential Equations II*, 2nd edition,
section VI.9; Mazzia and Magherini, *Test Set for Initial Value Problem Solvers*, release 2.4,
problem "Andrews' squeezing mechanism" (reference solution by PSIDE at tolerance 1e-14).
Also case A03 of the IFToMM library (Gonzalez, Dopico, Lugris, Cuadrado, Multibody System Dynamics
16 (2006) 179-190).
"""

from __future__ import annotations

import numpy as np

import jousto as jo
from verification.minimal import Array, Minimal, slopes, stack, turn

MASS = np.array([0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498])
INERTIA = np.array([2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5])
A, B, C = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)  # fixed points
D, DA, E, EA = 28e-3, 115e-4, 2e-2, 1421e-5
RR, RA, SS, SA, SB, SC, SD = 7e-3, 92e-5, 35e-3, 1874e-5, 1043e-5, 18e-3, 2e-2
TA, TB, U, UA, UB, ZF, ZT, FA = 2308e-5, 916e-5, 4e-2, 1228e-5, 449e-5, 2e-2, 4e-2, 1421e-5
STIFFNESS, FREE, TORQUE = 4530.0, 0.07785, 0.033
T_END = 0.03

# beta, Theta, gamma, Phi, delta, Omega, epsilon: consistent initial values
START = np.array(
    [
        -0.0617138900142764496358948458001,
        0.0,
        0.455279819163070380255912382449,
        0.222668390165885884674473185609,
        0.487364979543842550225598953530,
        -0.222668390165885884674473185609,
        1.23054744454982119249735015568,
    ]
)
START_ACCELERATION = np.array([14222.4439199541138705911625887, -10666.8329399655854029433719415])
# the published state at 0.03 s
ANGLES = np.array(
    [
        0.1581077119629904e2,
        -0.1575637105984298e2,
        0.4082224013073101e-1,
        -0.5347301163226948,
        0.5244099658805304,
        0.5347301163226948,
        0.1048080741042263e1,
    ]
)
RATES = np.array(
    [
        0.1139920302151208e4,
        -0.1424379294994111e4,
        0.1103291221937134e2,
        0.1929337464421385e2,
        0.5735699284790808,
        -0.1929337464421385e2,
        0.3231791658026955,
    ]
)
ACCELERATIONS = np.array(
    [
        -0.2463176316945196e5,
        0.5185037701610329e5,
        0.3241025686413781e6,
        0.5667493645176213e6,
        0.1674362929479361e5,
        -0.5667493645176222e6,
        0.9826520791458422e4,
    ]
)
# force on the bars K3, K4, K6 where they meet K2 (the multipliers of the three loops), N
REACTIONS = np.array(
    [
        [0.1991753333731910e3, -0.2975531228015052e2],
        [0.2306654119098399e2, 0.3145271365475927e2],
        [0.2264249232082739e2, 0.1161740700019673e2],
    ]
)

BARS = ("K1", "K2", "K3", "K4", "K5", "K6", "K7")
# centre of mass of every bar in its own frame
CENTRES = np.array([[RA, 0], [-DA, 0], [SB, -SA], [0, EA - E], [TA, TB], [ZF - FA, 0], [UA, -UB]])
ENDS = {"K2": (-D, 0), "K3": (0, -SS), "K4": (0, -E), "K6": (ZF, 0)}  # where four bars meet


def headings(q: Array) -> Array:
    """Angle of every bar's frame against the world (..., 7)."""
    beta, theta, gamma, phi, delta, omega, epsilon = np.moveaxis(q, -1, 0)
    return np.stack(
        [beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon], axis=-1
    )


def ray(angle: Array, x: float, y: float) -> Array:
    """Local point (x, y) of a frame at an angle, in world axes (..., 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def origins(q: Array) -> Array:
    """Origin of every bar's frame (..., 7, 2): its pivot on the ground or on the bar before."""
    angle = np.moveaxis(headings(q), -1, 0)
    zero = ray(angle[0], 0.0, 0.0)
    return np.stack(
        [
            zero,
            ray(angle[0], RR, 0.0),
            zero + B,
            A + ray(angle[4], ZT, 0.0),
            zero + A,
            A + ray(angle[6], 0.0, -U),
            zero + A,
        ],
        axis=-2,
    )


def points(q: Array, local: Array) -> Array:
    """One local point of every bar (7, 2) in the world (..., 7, 2)."""
    angle = headings(q)
    c, s = np.cos(angle), np.sin(angle)
    x, y = local.T
    return origins(q) + np.stack([c * x - s * y, s * x + c * y], axis=-1)


def place(q: Array) -> tuple[Array, Array]:
    """Centres (..., 7, 3) and axes (..., 7, 3, 3)."""
    r = points(q, CENTRES)
    return stack(r[..., 0], r[..., 1], 0.0), turn(2, headings(q))


def close(q: Array) -> Array:
    """The bars K3, K4 and K6 end where K2 ends (..., 6)."""
    ends = points(q, np.array([ENDS.get(bar, (0, 0)) for bar in BARS], dtype=float))
    return np.concatenate([ends[..., 1, :] - ends[..., k, :] for k in (2, 3, 5)], axis=-1)


def spring(q: Array) -> Array:
    """Length of the spring between K3 and the point C."""
    d = origins(q)[..., 2, :] + ray(q[..., 2], SD, -SC) - C
    return np.sqrt((d * d).sum(axis=-1))


def load(q: Array, _: Array) -> Array:
    """Spring and motor."""
    Q = -STIFFNESS * (spring(q) - FREE) * slopes(spring, q)
    Q[0] += TORQUE
    return Q


INERTIA_3D = INERTIA[:, None] * np.array([0.5, 0.5, 1.0])  # only the third is published
REFERENCE = Minimal(place, MASS, INERTIA_3D, np.zeros(3), close, load)


# -- the same in space -----------------------------------------------------------------------------

Z = (0.0, 0.0, 1.0)
LOOPS = ("K3", "K4", "K6")


def mechanism(*, repeated: bool) -> jo.Mechanism:
    """Seven bodies on revolute joints; the loops K2-K3, K2-K4, K2-K6 are closed by three more.

    Those repeat nine rows in all (`repeated`); a point on a line along z closes each loop with the
    two rows that a plane needs.
    """
    centres, angles = points(START, CENTRES), headings(START)
    named: dict[str, dict[str, tuple[float, float]]] = {bar: {"pivot": (0, 0)} for bar in BARS}
    named["K1"]["end"] = (RR, 0)
    named["K5"]["end"] = (ZT, 0)
    named["K7"]["end"] = (0, -U)
    named["K3"]["spring"] = (SD, -SC)
    for bar, end in ENDS.items():
        named[bar]["meeting"] = end
    bars = {
        bar: jo.RigidBody(
            bar,
            MASS[i],
            INERTIA_3D[i],
            markers={k: (*np.subtract(x, CENTRES[i]), 0.0) for k, x in named[bar].items()},
            position=(*centres[i], 0.0),
            orientation=jo.Rotate(Z, degrees=np.degrees(angles[i])),
        )
        for i, bar in enumerate(BARS)
    }
    foot = {name: jo.ground.at((*x, 0.0)) for name, x in (("A", A), ("B", B), ("O", (0, 0)))}
    held = [foot["O"], bars["K1"]["end"], foot["B"], bars["K5"]["end"], foot["A"]]
    held += [bars["K7"]["end"], foot["A"]]
    pivots = [
        jo.Revolute(f"{bar} pivot", held[i], bars[bar]["pivot"], Z) for i, bar in enumerate(BARS)
    ]
    kind = jo.Revolute if repeated else jo.PointOnLine
    meet = [kind(f"K2-{k}", bars["K2"]["meeting"], bars[k]["meeting"], Z) for k in LOOPS]
    spring = jo.Spring.between(
        "spring", jo.ground.at((*C, 0.0)), bars["K3"]["spring"], STIFFNESS, free=FREE
    )
    return jo.Mechanism(
        *bars.values(),
        *pivots,
        *meet,
        spring,
        jo.JointForce("motor", pivots[0].angle, TORQUE),
        *[jo.CoordinateSensor(f"{pivot.name} angle", pivot.angle) for pivot in pivots],
        *[jo.AngularVelocitySensor(f"{bar} rate", body["pivot"]) for bar, body in bars.items()],
        *[jo.ReactionSensor(joint.name, joint) for joint in meet],
        name="Andrews' squeezer",
    )
