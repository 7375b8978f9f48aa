"""Machines with flexible bodies for the tests of the advice."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

import jousto as jo

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
LENGTH, EI, LINE_MASS, TIP_MASS, TIME = 6.0, 2e6, 40.0, 100.0, 3.0


def boom_part(elements: int = 40) -> jo.Part:
    """Return a boom of 6 m with EI 2e6 N m2 and 40 kg/m."""
    # as slender as the formula assumes: rotary inertia changes the frequency by 5e-9
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # stiffer than diamond
        material = jo.Material(E=2e15, nu=0.3, rho=7850.0)
    moment = EI / material.E
    section = jo.sections.GeneralSection(A=LINE_MASS / 7850.0, Iy=moment, Iz=moment, J=moment)
    return jo.Part.beam(LENGTH, section, elements, material, theory=jo.parts.EulerBernoulli())


def slewing_boom(*more: object) -> jo.Mechanism:
    """Return the boom on a hub that turns by a quarter in 3 s, a tip of 100 kg, no gravity.

    The angle is ``(pi/2) (x - sin(2 pi x) / (2 pi))``, ``x = t / 3 s``.
    """
    method = jo.CraigBampton(("start", "end"), modes=60)
    reduced = jo.reduce(boom_part(), method)
    boom = jo.FlexibleBody("boom", reduced.keep(reduced.in_plane("xy")))
    load = jo.RigidBody("load", TIP_MASS, (1e-9, 1e-9, 1e-9), position=(LENGTH, 0, 0))
    hub = jo.Revolute("hub", jo.ground["origin"], boom["start"], axis=(0, 0, 1))
    tip = jo.Spherical("tip joint", boom["end"], load["origin"])
    even = jo.Ramp(-TIME, 2.0 * TIME, -0.5 * np.pi, np.pi)
    turn = even + jo.Harmonic(amplitude=-0.25, frequency=1.0 / TIME)
    drive = jo.Drive("slew", hub.angle, turn)
    sensor = jo.PositionSensor("tip", boom["end"])
    return jo.Mechanism(boom, load, hub, tip, drive, sensor, *more, name="slewing boom")


def hub_acceleration(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angular acceleration of the hub, rad/s2."""
    return np.asarray(np.pi**2 / TIME**2 * np.sin(2.0 * np.pi * t / TIME))


def arm(name: str = "arm", *, thick: float = 0.02, elements: int = 4) -> jo.FlexibleBody:
    """Return a flexible arm of 1 m of steel, twice as wide as thick."""
    part = jo.Part.beam(1.0, jo.Rectangle(width=2 * thick, height=thick), elements, STEEL)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=3))
    return jo.FlexibleBody(name, reduced, damping=0.02)


def driven_arm(*more: object, thick: float = 0.02) -> jo.Mechanism:
    """Return an arm that a drive swings by half a radian in 1 s under its weight."""
    body = arm(thick=thick)
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], axis=(0, 1, 0))
    drive = jo.Drive("drive", hinge.angle, jo.SCurve((0.0, 1.0), (0.0, 0.5)))
    tip = jo.PositionSensor("tip", body["end"])
    gravity = jo.Gravity((0, 0, -9.81))
    return jo.Mechanism(body, hinge, drive, gravity, tip, *more, name="arm", start="rest")
