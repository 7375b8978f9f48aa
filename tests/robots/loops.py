"""Machines with loops for the tests of inverse kinematics, and their closed forms."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

import jousto as jo

GROUND, CRANK, COUPLER, ROCKER = 0.40, 0.12, 0.36, 0.28  # m
INERTIA = (0.01, 0.01, 0.01)


def quietly(*items: Any) -> jo.Mechanism:
    """A mechanism, and no word of what moves freely."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return jo.Mechanism(*items)


def compiled(machine: jo.Mechanism, **options: Any) -> jo.Model:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return jo.compile(machine, **options)


def about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def freudenstein(theta: float, branch: int = 1) -> float:
    """Angle of the rocker for that of the crank, both against the line of the fixed pivots.

    F. Freudenstein, Approximate Synthesis of Four-Bar Linkages, Trans. ASME 77 (1955):
    ``k1 cos phi - k2 cos theta + k3 = cos(theta - phi)``, here solved for phi by the half angle.
    """
    k1, k2 = GROUND / CRANK, GROUND / ROCKER
    k3 = (CRANK**2 - COUPLER**2 + ROCKER**2 + GROUND**2) / (2.0 * CRANK * ROCKER)
    # (k1 - cos theta) cos phi - sin theta sin phi = k2 cos theta - k3
    a, b = k1 - np.cos(theta), -np.sin(theta)
    return float(np.arctan2(b, a) + branch * np.arccos((k2 * np.cos(theta) - k3) / np.hypot(a, b)))


def four_bar(theta: float = 0.9, *more: Any) -> jo.Mechanism:
    """Revolutes alone: three rows of the plane are there twice."""
    phi = freudenstein(theta)
    end = CRANK * np.array([np.cos(theta), np.sin(theta), 0.0])
    tip = np.array([GROUND, 0, 0]) + ROCKER * np.array([np.cos(phi), np.sin(phi), 0.0])
    bend = np.arctan2(*(tip - end)[[1, 0]])
    z = (0, 0, 1)

    def bar(name: str, length: float, angle: float, at: Any) -> jo.RigidBody:
        points = {"end": (length, 0, 0), "point": (0.5 * length, 0.1, 0)}
        turned = jo.Rotate(z, degrees=np.degrees(angle))
        return jo.RigidBody(name, 1.0, INERTIA, markers=points, position=at, orientation=turned)

    crank, coupler = bar("crank", CRANK, theta, (0, 0, 0)), bar("coupler", COUPLER, bend, end)
    rocker = bar("rocker", ROCKER, phi, (GROUND, 0, 0))
    joints = (
        jo.Revolute("drive", jo.ground["origin"], crank["origin"]),
        jo.Revolute("pin", crank["end"], coupler["origin"]),
        jo.Revolute("swing", jo.ground.at((GROUND, 0, 0)), rocker["origin"]),
        jo.Revolute("link", coupler["end"], rocker["end"]),
    )
    return quietly(crank, coupler, rocker, *joints, jo.Gravity((0, -9.81, 0)), *more)


def slider_crank(kind: str, r: float = 0.1, length: float = 0.25) -> jo.Mechanism:
    """Its rod a body between revolutes, or a `Rod` without mass."""
    x = r + length
    crank = jo.RigidBody("crank", 1.0, INERTIA, markers={"end": (r, 0, 0)})
    block = jo.RigidBody("block", 1.0, INERTIA, position=(x, 0, 0))
    drive = jo.Revolute("drive", jo.ground["origin"], crank["origin"])
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    if kind == "rod":
        rod = jo.Rod("rod", crank["end"], block["origin"])
        return quietly(crank, block, drive, slide, rod)
    bar = jo.RigidBody("bar", 1.0, INERTIA, markers={"end": (length, 0, 0)}, position=(r, 0, 0))
    big = jo.Revolute("big", crank["end"], bar["origin"])
    small = jo.Revolute("small", bar["end"], block["origin"])
    return quietly(crank, bar, block, drive, big, small, slide)


def hexagon(radius: float, apart: float, first: float) -> np.ndarray:
    """Three pairs of points (6, 3) on a circle, `apart` rad between those of a pair."""
    pairs = first + np.repeat(np.arange(3) * 2.0 * np.pi / 3.0, 2)
    angles = pairs + 0.5 * apart * np.tile([-1.0, 1.0], 3)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(6)])


BASE, PLATE = hexagon(0.5, 0.4, 0.0), hexagon(0.3, 1.6, 0.0)


def stewart() -> jo.Mechanism:
    """Six legs of a universal joint, a slide and a ball; slides read the lengths of the legs."""
    height = np.array([0, 0, 0.6])
    names = {f"p{i}": point for i, point in enumerate(PLATE)}
    plate = jo.RigidBody("plate", 5.0, (0.2, 0.2, 0.4), markers=names, position=height)
    items: list[Any] = [plate]
    for i, (a, b) in enumerate(zip(BASE, PLATE + height, strict=True)):
        along = (b - a) / np.linalg.norm(b - a)
        across = np.cross(along, (0, 0, 1))
        across /= np.linalg.norm(across)
        lower = jo.RigidBody(f"lower{i}", 1.0, INERTIA, position=a)
        upper = jo.RigidBody(f"upper{i}", 1.0, INERTIA, position=b)
        items += [lower, upper]
        first = np.cross(along, across)
        foot = jo.Universal(
            f"foot{i}", jo.ground.at(a), lower["origin"], axis_a=across, axis_b=first
        )
        items += [foot, jo.Prismatic(f"leg{i}", lower["origin"], upper["origin"], axis=along)]
        items += [jo.Spherical(f"ball{i}", upper["origin"], plate[f"p{i}"])]
    return quietly(*items)


ARM, FOREARM, SHOULDER, WRIST, HALF = 0.20, 0.45, 0.18, 0.06, 0.03  # m


def delta() -> jo.Mechanism:
    """R. Clavel's robot: three arms, and between each and the plate a parallelogram of rods."""
    drop = np.sqrt(FOREARM**2 - (SHOULDER + ARM - WRIST) ** 2)
    sides = {}
    for k in range(3):
        for s in (-1, 1):
            sides[f"w{k}{s:+d}"] = about_z(k * 2 * np.pi / 3) @ (WRIST, s * HALF, 0.0)
    plate = jo.RigidBody("plate", 0.5, INERTIA, markers=sides, position=(0, 0, -drop))
    items: list[Any] = [plate]
    for k in range(3):
        A = about_z(k * 2 * np.pi / 3)
        ends = {f"e{s:+d}": (ARM, s * HALF, 0.0) for s in (-1, 1)}
        at = A @ (SHOULDER, 0, 0)
        arm = jo.RigidBody(f"arm{k}", 1.0, INERTIA, markers=ends, position=at, orientation=A)
        motor = jo.Revolute(f"motor{k}", jo.ground.at(at), arm["origin"], axis=A @ (0, 1, 0))
        rods = [jo.Rod(f"rod{k}{s:+d}", arm[f"e{s:+d}"], plate[f"w{k}{s:+d}"]) for s in (-1, 1)]
        items += [arm, motor, *rods]
    return quietly(*items)


def delta_angles(position: Any) -> np.ndarray:
    """Angles of the motors below the horizontal that bring the plate to a position.

    In the plane of an arm: ``|(u - ARM cos phi, v, z + ARM sin phi)| = FOREARM``, u and v being
    the plate's wrist from the shoulder along the arm and across; the elbow out.
    """
    found = []
    for k in range(3):
        x, y, z = about_z(-k * 2 * np.pi / 3) @ np.asarray(position)
        u = x + WRIST - SHOULDER
        # -2 ARM u cos phi + 2 ARM z sin phi = FOREARM^2 - ARM^2 - u^2 - y^2 - z^2
        a, b = -2 * ARM * u, 2 * ARM * z
        c = FOREARM**2 - ARM**2 - u * u - y * y - z * z
        middle, half = np.arctan2(b, a), np.arccos(c / np.hypot(a, b))
        both = [np.arctan2(np.sin(p), np.cos(p)) for p in (middle - half, middle + half)]
        found.append(max(both, key=np.cos))
    return np.array(found)
