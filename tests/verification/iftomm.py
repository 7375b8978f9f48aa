"""Cases of the IFToMM benchmark library with independent references.

Gonzalez, Dopico, Lugris, Cuadrado, *A benchmarking system for MBS simulation software*, Multibody
System Dynamics 16 (2006) 179-190; cases A02 to A05 of the library of the Universidad de La Coruna,
and the spatial slider-crank of the library at iftomm-multibody.org. Parameters as documented there
and in Tagliapietra, Vivian, Reggiani, Ceseracciu (OpenSim versions of A01 to A05). World axes are
those of each case.
"""

from __future__ import annotations

import numpy as np

import jousto as jo
from verification.minimal import Array, Minimal, axial, slopes, stack, turn

ROD = 0.01  # m, side of the square rods of the governor
Y_DOWN, Z_DOWN = np.array([0.0, -9.81, 0.0]), np.array([0.0, 0.0, -9.81])


def bar(length: float, side: float, mass: float) -> Array:
    """Principal inertia (3,) of a square bar along x."""
    across = mass * (length**2 + side**2) / 12
    return np.array([mass * side**2 / 6, across, across])


# -- A01: simple pendulum --------------------------------------------------------------------------


def simple_pendulum() -> jo.Mechanism:
    """A point of 1 kg on a massless rod of 1 m, at rest at (-1, 0).

    The rod holds the centre of a ball, which does not turn: its inertia does not matter.
    """
    ball = jo.RigidBody("ball", 1.0, (1.0, 1.0, 1.0), position=(-1, 0, 0))
    rod = jo.Rod("rod", jo.ground["origin"], ball["origin"])
    sensor = jo.PositionSensor("P1", ball["origin"])
    return jo.Mechanism(ball, rod, jo.Gravity(Y_DOWN), sensor, name="simple pendulum")


# -- A02: N windows of four bars in a row; all uprights are parallel -------------------------------


def upright(n: int) -> Minimal:
    """N four-bars of slender links of 1 m and 1 kg; q = angle of the uprights against x."""

    def place(q: Array) -> tuple[Array, Array]:
        angle = q[..., 0]
        x, y = np.cos(angle), np.sin(angle)
        zero = 0 * angle
        low = [stack(x / 2 + k, y / 2, zero) for k in range(n + 1)]
        high = [stack(x + k + 0.5, y, zero) for k in range(n)]
        A, E = turn(2, angle), turn(2, zero)
        return np.stack(low + high, axis=-2), np.stack([A] * (n + 1) + [E] * n, axis=-3)

    count = 2 * n + 1
    return Minimal(place, np.ones(count), np.tile(bar(1.0, 0.0, 1.0), (count, 1)), Y_DOWN)


def four_bars(n: int) -> jo.Mechanism:
    """The same of 2N+1 bodies; B0 is the tip of the first upright.

    The feet are revolute joints, the decks hang on spherical ones: nothing is redundant, and the
    decks, at rest about their own axes, stay so.
    """
    I = bar(1.0, 1e-5, 1.0)
    ups, decks, joints = [], [], []
    for k in range(n + 1):
        up = jo.RigidBody(
            f"upright {k}",
            1.0,
            I,
            markers={"low": (-0.5, 0, 0), "high": (0.5, 0, 0)},
            position=(k, 0.5, 0),
            orientation=jo.Rotate((0, 0, 1), degrees=90.0),
            velocity=(0.5, 0, 0),
            angular_velocity=(0, 0, -1.0),
        )
        ups.append(up)
        joints.append(jo.Revolute(f"foot {k}", jo.ground.at((k, 0, 0)), up["low"], axis=(0, 0, 1)))
    for k in range(n):
        deck = jo.RigidBody(
            f"deck {k}",
            1.0,
            I,
            markers={"left": (-0.5, 0, 0), "right": (0.5, 0, 0)},
            position=(k + 0.5, 1.0, 0),
            velocity=(1.0, 0, 0),
        )
        decks.append(deck)
        for end, up in (("left", ups[k]), ("right", ups[k + 1])):
            joints.append(jo.Spherical(f"deck {k} {end}", up["high"], deck[end]))
    sensors = (jo.PositionSensor("B0", ups[0]["high"]), jo.VelocitySensor("B0'", ups[0]["high"]))
    return jo.Mechanism(*ups, *decks, *joints, jo.Gravity(Y_DOWN), *sensors, name=f"{n} four-bars")


# -- A04: Bricard's mechanism: five bars along the edges of a cube, six revolute joints ------------

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], float)
AXES = (1, 2, 0, 1, 2, 0)  # y z x y z x at the corners
EDGES = np.diff(CORNERS, axis=0)
BRICARD_BAR = bar(1.0, 0.1, 1.0)
BRICARD_INERTIA = np.array([np.roll(BRICARD_BAR, int(np.abs(e).argmax())) for e in EDGES])


def bricard_frames(q: Array) -> tuple[Array, Array]:
    """Corners (..., 6, 3) and frames (..., 5, 3, 3) of the open chain with five joint angles."""
    R, r = turn(2, 0 * q[..., 0]), stack(0 * q[..., 0], 0.0, 0.0)
    corners, frames = [r], []
    for k in range(5):
        R = R @ turn(AXES[k], q[..., k])
        r = r + R @ EDGES[k]
        frames.append(R)
        corners.append(r)
    return np.stack(corners, axis=-2), np.stack(frames, axis=-3)


def bricard_place(q: Array) -> tuple[Array, Array]:
    corners, frames = bricard_frames(q)
    return 0.5 * (corners[..., :-1, :] + corners[..., 1:, :]), frames


def bricard_close(q: Array) -> Array:
    """The last bar ends at the sixth corner and its axis stays along x: 5 rows, 4 independent."""
    corners, frames = bricard_frames(q)
    return np.concatenate([corners[..., -1, :] - CORNERS[-1], frames[..., -1, 1:, 0]], axis=-1)


BRICARD = Minimal(bricard_place, np.ones(5), BRICARD_INERTIA, Y_DOWN, bricard_close)


def bricard(inertia: Array | None = None) -> jo.Mechanism:
    """Five bodies and six revolute joints: 30 rows for 30 velocities, and yet it moves."""
    moments = BRICARD_INERTIA if inertia is None else inertia
    bars = [
        jo.RigidBody(
            f"bar {k + 1}",
            1.0,
            moments[k],
            markers={"start": -EDGES[k] / 2, "end": EDGES[k] / 2},
            position=CORNERS[k] + EDGES[k] / 2,
        )
        for k in range(5)
    ]
    joints = []
    for k in range(6):
        a = jo.ground["origin"] if k == 0 else bars[k - 1]["end"]
        b = jo.ground.at(CORNERS[5]) if k == 5 else bars[k]["start"]
        joints.append(jo.Revolute(f"hinge {k}", a, b, axis=np.eye(3)[AXES[k]]))
    sensors = jo.PositionSensor("P3", bars[2]["end"])
    return jo.Mechanism(*bars, *joints, jo.Gravity(Y_DOWN), sensors, name="Bricard")


# -- A05: stiff flyball governor -------------------------------------------------------------------

BALL, GOVERNOR_ROD = 5.0, 0.3
ARM_MASS = BALL + GOVERNOR_ROD
ARM_CENTRE = (GOVERNOR_ROD * 0.5 + BALL) / ARM_MASS
_ACROSS = (
    GOVERNOR_ROD * (1 + ROD**2) / 12
    + GOVERNOR_ROD * (ARM_CENTRE - 0.5) ** 2
    + BALL * (1 - ARM_CENTRE) ** 2
)
ARM_INERTIA = np.array([GOVERNOR_ROD * ROD**2 / 6, _ACROSS, _ACROSS])
SHAFT_INERTIA = np.roll(bar(1.0, ROD, GOVERNOR_ROD), -1)
SLIDER_INERTIA = np.full(3, 3.0 * 0.1**2 / 6)
SPRING, DAMPER, SPRING_FREE = 8e5, 4e4, 0.5
GOVERNOR_START = np.array([0.0, 0.5, np.pi / 6, np.pi / 6])
GOVERNOR_RATES = np.array([2 * np.pi, 0.0, 0.0, 0.0])


def governor_place(q: Array) -> tuple[Array, Array]:
    """q = turn of the shaft, height of the slider, angles of the two arms below horizontal."""
    f, s, b1, b2 = np.moveaxis(q, -1, 0)
    S, zero = turn(2, f), 0 * f
    R1, R2 = S @ turn(1, b1), S @ turn(1, np.pi - b2)
    x = S[..., :, 0] * 0.05
    top = stack(zero, zero, zero + 1)
    r = [stack(zero, zero, zero + 0.5), stack(zero, zero, s)]
    r += [top + x + ARM_CENTRE * R1[..., :, 0], top - x + ARM_CENTRE * R2[..., :, 0]]
    return np.stack(r, axis=-2), np.stack([S, S, R1, R2], axis=-3)


def governor_springs(q: Array) -> Array:
    """Lengths (..., 2): from the slider's sides to the middles of the arms."""
    d = [
        (0.5 * np.cos(q[..., k])) ** 2 + (1 - 0.5 * np.sin(q[..., k]) - q[..., 1]) ** 2
        for k in (2, 3)
    ]
    return np.sqrt(np.stack(d, axis=-1))


def governor_load(q: Array, v: Array) -> Array:
    J = slopes(governor_springs, q)
    return J @ (-SPRING * (governor_springs(q) - SPRING_FREE) - DAMPER * (v @ J))


GOVERNOR = Minimal(
    governor_place,
    np.array([GOVERNOR_ROD, 3.0, ARM_MASS, ARM_MASS]),
    np.array([SHAFT_INERTIA, SLIDER_INERTIA, ARM_INERTIA, ARM_INERTIA]),
    Z_DOWN,
    None,
    governor_load,
)


def governor() -> jo.Mechanism:
    """The same of four bodies."""
    z, y = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
    r, A = governor_place(GOVERNOR_START)
    w = np.array([0.0, 0.0, GOVERNOR_RATES[0]])

    def body(k: int, name: str, **markers: tuple[float, float, float]) -> jo.RigidBody:
        return jo.RigidBody(
            name,
            GOVERNOR.mass[k],
            GOVERNOR.inertia[k],
            markers=markers,
            position=r[k],
            orientation=A[k],
            velocity=np.cross(w, r[k]),
            angular_velocity=w,
        )

    shaft = body(0, "shaft", low=(0, 0, -0.5), right=(0.05, 0, 0.5), left=(-0.05, 0, 0.5))
    slider = body(1, "slider", right=(0.05, 0, 0), left=(-0.05, 0, 0))
    ends = {"hinge": (-ARM_CENTRE, 0, 0), "middle": (0.5 - ARM_CENTRE, 0, 0)}
    arms = {"right": body(2, "right arm", **ends), "left": body(3, "left arm", **ends)}
    slide = jo.Prismatic("slide", shaft["low"], slider["origin"], z)
    hinges = [jo.Revolute(f"{k} hinge", shaft[k], arm["hinge"], y) for k, arm in arms.items()]
    springs = [
        jo.Spring.between(f"{k} rod", slider[k], arm["middle"], SPRING, DAMPER, SPRING_FREE)
        for k, arm in arms.items()
    ]
    bearing = jo.Revolute("bearing", jo.ground["origin"], shaft["low"], z)
    return jo.Mechanism(
        *(shaft, slider, *arms.values(), bearing, slide, *hinges, *springs),
        jo.Gravity(Z_DOWN),
        jo.CoordinateSensor("s", slide.displacement),
        jo.RateSensor("s'", slide.displacement),
        jo.CoordinateSensor("turn", bearing.angle),
        jo.RateSensor("turn'", bearing.angle),
        name="flyball governor",
    )


# -- spatial slider-crank --------------------------------------------------------------------------

CRANK, CONROD = 0.08, 0.3
PIVOT = np.array([0.0, 0.1, 0.12])
CRANK_INERTIA, CONROD_INERTIA = np.array([1e-4, 1e-5, 1e-4]), np.array([4e-4, 4e-3, 4e-3])


def spatial_frames(q: Array) -> tuple[Array, Array, Array]:
    """Crank pin B, slider C (..., 3) and frame of the rod; q = turn of the crank about x.

    The rod's y axis is square to the axis of the slide: the cross of the universal joint.
    """
    angle = q[..., 0]
    B = stack(0.0, 0.1 - CRANK * np.sin(angle), 0.12 + CRANK * np.cos(angle))
    C = stack(np.sqrt(CONROD**2 - B[..., 1] ** 2 - B[..., 2] ** 2), 0.0, 0.0)
    x = (C - B) / CONROD
    y = stack(0.0, -x[..., 2], x[..., 1])
    y = y / np.sqrt((y * y).sum(axis=-1))[..., None]
    return B, C, np.stack([x, y, np.cross(x, y)], axis=-1)


def spatial_place(q: Array) -> tuple[Array, Array]:
    B, C, R = spatial_frames(q)
    A = turn(0, q[..., 0])
    return np.stack([(PIVOT + B) / 2, (B + C) / 2, C], axis=-2), np.stack(
        [A, R, turn(0, 0 * q[..., 0])], axis=-3
    )


SPATIAL = Minimal(
    spatial_place,
    np.array([0.12, 0.5, 2.0]),
    np.array([CRANK_INERTIA, CONROD_INERTIA, np.full(3, 1e-4)]),
    Z_DOWN,
)


def spatial_slider_crank() -> jo.Mechanism:
    """The same of three bodies: revolute, spherical, universal and prismatic joints."""
    x = np.array([1.0, 0.0, 0.0])
    B, C, R = spatial_frames(np.zeros(1))
    (r, A), (r_q, A_q) = spatial_place(np.zeros(1)), spatial_slopes()
    rate = 6.0
    bodies = [
        jo.RigidBody(
            name,
            SPATIAL.mass[k],
            SPATIAL.inertia[k],
            markers={end: A[k].T @ (p - r[k]) for end, p in (("start", start), ("end", stop))},
            position=r[k],
            orientation=A[k],
            velocity=rate * r_q[k],
            angular_velocity=rate * axial(A_q[k] @ A[k].T),
        )
        for k, (name, start, stop) in enumerate(
            (("crank", PIVOT, B), ("rod", B, C), ("slider", C, C))
        )
    ]
    crank, rod, slider = bodies
    joints = (
        jo.Revolute("pivot", jo.ground.at(PIVOT), crank["start"], x),
        jo.Spherical("pin", crank["end"], rod["start"]),
        jo.Universal("cross", slider["start"], rod["end"], x, R[:, 1]),
        jo.Prismatic("slide", jo.ground["origin"], slider["end"], x),
    )
    sensor = jo.PositionSensor("slider", slider["start"])
    return jo.Mechanism(*bodies, *joints, jo.Gravity(Z_DOWN), sensor, name="spatial slider-crank")


def spatial_slopes() -> tuple[Array, Array]:
    """dr/dq and dA/dq at the start."""
    r_q = slopes(lambda q: spatial_place(q)[0], np.zeros(1))
    return r_q[0], slopes(lambda q: spatial_place(q)[1], np.zeros(1))[0]
