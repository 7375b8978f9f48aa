"""Events and switched signals as declarations: what is refused, and with which sentence."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo


def parts():
    body = jo.RigidBody("body", 1.0, (1, 1, 1), velocity=(1, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    return body, rail, jo.PositionSensor("place", body["origin"])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"threshold": np.nan}, "threshold is nan, must be finite"),
        ({"threshold": "high"}, "threshold"),
        ({"direction": "up"}, "direction is 'up'"),
        ({"component": None}, "sensor 'place' has 3 components, name one: x, y, z"),
        ({"component": "w"}, "sensor 'place' has no component 'w'; known: x, y, z"),
        ({"component": 3}, "sensor 'place' has no component 3"),
        ({"watch": "place"}, "watch is 'place', must be a sensor or a coordinate"),
    ],
)
def test_impossible_events(arguments, sentence):
    values = {"watch": parts()[2], "component": "x", **arguments}
    with pytest.raises(jo.InputError) as error:
        jo.mechanism.Event("crossing", **values)
    assert sentence in str(error.value)
    assert "event 'crossing'" in str(error.value)


def test_what_an_event_refers_to_must_be_in_the_mechanism():
    body, rail, place = parts()
    other_body, other_rail, other_place = parts()
    watching = jo.mechanism.Event("watching", place, component="x")
    twin = jo.mechanism.Event("twin", other_place, component="x")
    far = jo.mechanism.Event("far", other_rail.displacement)
    push = jo.JointForce("push", rail.displacement, 2.0 * jo.mechanism.Switched(watching, 0.0, 1.0))
    with pytest.raises(jo.InputError) as error:
        jo.Mechanism(body, rail, push, twin, far, other_place)
    text = str(error.value)
    assert "event 'far': rail.displacement: body 'body' is not the body of that name" in text
    assert (
        "joint force 'push': its signal is switched by event 'watching', which is not in the "
        "mechanism; add it" in text
    )
    with pytest.raises(jo.InputError) as error:
        jo.Mechanism(body, rail, place, twin)
    assert (
        "event 'twin': watches sensor 'place', which is not the sensor of that name in the "
        "mechanism" in str(error.value)
    )
    with pytest.raises(jo.InputError) as error:
        jo.Mechanism(body, rail, watching)
    assert "event 'watching': watches sensor 'place', which is not in the mechanism; add it" in str(
        error.value
    )


def test_events_of_one_name_are_refused():
    body, rail, place = parts()
    events = [jo.mechanism.Event("stop", rail.displacement, x) for x in (0.1, 0.2)]
    with pytest.raises(jo.InputError, match="event 'stop': 2 events have this name"):
        jo.Mechanism(body, rail, place, *events)


def test_a_switched_signal_has_no_value_of_its_own():
    body, rail, _ = parts()
    event = jo.mechanism.Event("limit", rail.displacement, 0.1)
    signal = jo.mechanism.Switched(event, 1.0, jo.Harmonic(frequency=1.0))
    with pytest.raises(jo.InputError, match="switched by event 'limit'"):
        signal(0.0)
    with pytest.raises(jo.InputError, match="event is 'limit', must be an Event"):
        jo.mechanism.Switched("limit", 0.0, 1.0)
    del body


def test_watched_coordinates_are_recorded_once():
    body, rail, place = parts()
    first = jo.mechanism.Event("first", rail.displacement, 0.1)
    second = jo.mechanism.Event("second", rail.displacement, 0.2)
    model = jo.compile(jo.Mechanism(body, rail, place, first, second))
    assert [sensor.name for sensor in model.sensors] == ["place", "rail.displacement"]
    assert [event.output for event in model.events] == [3, 3]
    named = jo.CoordinateSensor("way", rail.displacement)
    model = jo.compile(jo.Mechanism(body, rail, named, first))
    assert [sensor.name for sensor in model.sensors] == ["way"]
    taken = jo.RateSensor("rail.displacement", rail.displacement)
    model = jo.compile(jo.Mechanism(body, rail, taken, first))
    names = [sensor.name for sensor in model.sensors]
    assert names == ["rail.displacement", "first.rail.displacement"]
    assert model.events[0].output == 1
