"""Machines whose numbers the tests identify."""

from pathlib import Path

import numpy as np

import jousto as jo

DATA = Path(__file__).parent / "data"


def read(name):
    """Return a record of the data."""
    return jo.gauges.read_record(DATA / f"{name}.csv")


def block(name, mass, on=None):
    """Return a body on a slide along x."""
    body = jo.RigidBody(name, mass, (1.0, 1.0, 1.0))
    base = jo.ground["origin"] if on is None else on["origin"]
    return body, jo.Prismatic(f"{name} slide", base, body["origin"], axis=(1, 0, 0))


def two_masses(m1, m2, k1, k2, c1, c2):
    """Return two masses in a row on springs, with a force on the second."""
    a, first = block("a", m1)
    b, second = block("b", m2, a)
    return jo.Mechanism(
        a,
        b,
        first,
        second,
        jo.Spring("f1", first.displacement, k1, damping=c1),
        jo.Spring("f2", second.displacement, k2, damping=c2),
        jo.Force("push", b["origin"], (1, 0, 0), signal=jo.Input("force")),
        jo.CoordinateSensor("x1", first.displacement),
        jo.AccelerationSensor("a2", b["origin"]),
    )


def oscillator(k, c=0.0, mass=1.5, start=0.0):
    """Return a mass on a spring with a damper and a force along it."""
    body, slide = block("block", mass)
    return jo.Mechanism(
        body,
        slide,
        jo.Spring("coil", slide.displacement, k, damping=c),
        jo.JointForce("push", slide.displacement, jo.Input("force")),
        jo.CoordinateSensor("x", slide.displacement),
        jo.Initial(slide.displacement, value=start),
    )


def released(k=50.0, mass=2.0, start=0.1, samples=101, t_end=2.0):
    """Return instants and the exact motion of a mass that is let go on a spring."""
    t = np.linspace(0.0, t_end, samples)
    return t, start * np.cos(np.sqrt(k / mass) * t)


def record(t, x, noise=0.0, seed=1, name="test", unit="m"):
    """Return a record of one channel x with noise."""
    disturbed = x + noise * np.random.default_rng(seed).normal(size=len(x))
    return jo.gauges.Record(t, {"x": disturbed}, {"x": unit}, name)
