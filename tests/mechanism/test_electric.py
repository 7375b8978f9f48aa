"""Electric drives: what is refused before the run, by name and with a remedy."""

from __future__ import annotations

from typing import Any

import pytest

import jousto as jo
from jousto.base.declare import kinds
from jousto.base.errors import InputError
from jousto.electric import Brake, DCMotor, Gearbox, SynchronousMotor, ThermalLoad

ROTOR, LOAD = (jo.RigidBody(name, 1.0, (1, 1, 1)) for name in ("rotor", "load"))
AXLE, DRUM = (
    jo.Revolute(f"{x.name} axle", jo.ground["origin"], x["origin"]) for x in (ROTOR, LOAD)
)
RAIL = jo.Prismatic("rail", jo.ground["origin"], LOAD["origin"])


def motor(**options: Any) -> SynchronousMotor:
    return SynchronousMotor("m", AXLE.angle, 0.5, 2e-3, 3e-3, 0.08, 4, **options)


def gear(**options: Any) -> Gearbox:
    return Gearbox("g", AXLE.angle, DRUM.angle, 20.0, 1e5, **options)


REFUSED: dict[str, tuple[Any, str]] = {
    "no resistance": (lambda: DCMotor("m", AXLE.angle, 12.0, 0.0, 1e-3, 0.1), r"resistance"),
    "no input": (motor, r"give voltage_d and voltage_q, or current and bandwidth"),
    "two inputs": (
        lambda: motor(current=1.0, bandwidth=1e3, voltage_d=1.0),
        r"has a current and voltages; give either",
    ),
    "no bandwidth": (lambda: motor(current=1.0), r"bandwidth .* is missing.*a tenth of its sampl"),
    "a control without control": (
        lambda: motor(voltage_d=0.0, voltage_q=1.0, dc_voltage=60.0),
        r"dc_voltage is given, which only a current control has; give current",
    ),
    "weakening without voltage": (
        lambda: motor(current=1.0, bandwidth=1e3, weakening=True),
        r"weakening needs dc_voltage and largest_current; give both",
    ),
    "weakening of a given current": (
        lambda: motor(
            current=1.0,
            current_d=0.0,
            bandwidth=1e3,
            weakening=True,
            dc_voltage=60.0,
            largest_current=20.0,
        ),
        r"weakening chooses id itself; leave current_d out",
    ),
    "ideal within a voltage": (
        lambda: motor(current=1.0, bandwidth=1e3, ideal=True, dc_voltage=60.0),
        r"ideal currents follow at any voltage; leave out ideal or dc_voltage",
    ),
    "word of a strategy": (
        lambda: motor(current=1.0, bandwidth=1e3, strategy="least"),
        r"strategy",
    ),
    "gear of a length": (
        lambda: Gearbox("g", RAIL.displacement, DRUM.angle, 1.0, 1e5),
        r"motor is rail.displacement, a length; must be an angle",
    ),
    "gear of one angle": (
        lambda: Gearbox("g", AXLE.angle, AXLE.angle, 1.0, 1e5),
        r"couples rotor axle.angle with itself",
    ),
    "efficiency above 1": (lambda: gear(efficiency=1.1), r"efficiency is 1.1"),
    "negative backlash": (lambda: gear(backlash=-0.1), r"backlash is -0.1"),
    "static below kinetic": (
        lambda: Brake("b", AXLE.angle, 12.0, 1e5, 10.0),
        r"static is 10, must not be below torque, 12",
    ),
    "largest below rated": (
        lambda: ThermalLoad("t", 1.0, rated=4.0, time=60.0, largest=3.0),
        r"largest is 3 A, must not be below rated, 4 A",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_refused(what: str) -> None:
    make, message = REFUSED[what]
    with pytest.raises(InputError, match=message):
        make()


def test_an_unknown_output_is_named() -> None:
    with pytest.raises(InputError, match=r"DC motor 'm': has no 'curent'; did you mean 'current'"):
        DCMotor("m", AXLE.angle, 12.0, 1.0, 1e-3, 0.1)["curent"]


def test_every_block_is_public() -> None:
    every = kinds("states", "jousto.mechanism.electric").values()
    found = {one for one in every if ".electric." in one.__module__}
    assert found == {getattr(jo.electric, name) for name in jo.electric.__all__}
