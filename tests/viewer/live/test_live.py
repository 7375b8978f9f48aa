"""A running machine behind its server: scene, orders, pictures, parameters, two pages, an end."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from websockets.sync.client import ClientConnection, connect

import jousto as jo
from jousto.simulation.live.drag_spring import point_position
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.runner import Runner
from jousto.viewer import server as server_module
from jousto.viewer.container import pack, unpack
from jousto.viewer.live.live import Live, live
from jousto.viewer.live.session import LiveDesk
from jousto.viewer.live.sources import OpenedMachine

PATIENCE = 60.0  # s, for machines that are busy

MODEL = """
name: swing
parameters:
  load: {value: 2 kg, bounds: [1 kg, 5 kg]}
bodies:
  - name: bob
    mass: ${load}
    inertia: [1e-2, 1e-2, 1e-2]
    position: [0, 0, -1]
    markers: {eye: [0, 0, 1]}
joints:
  - {type: revolute, name: pivot, a: ground.origin, b: bob.eye, axis: [0, 1, 0]}
forces:
  - {type: joint-force, name: motor, coordinate: pivot.angle, signal: {type: input, name: torque}}
gravity: [0, 0, -9.81]
sensors: [{type: position, name: place, marker: bob.origin}]
simulation: {t_end: 1 s, solver: {type: RK4, step: 1 ms}}
"""


@pytest.fixture(autouse=True)
def bundle(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page itself is not looked at here."""
    monkeypatch.setattr(server_module, "read_bundle", lambda: {"viewer.js": b"", "viewer.css": b""})


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "swing.yaml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def running(model: Path) -> Iterator[Live]:
    made = live(model, open=False, speed=0, playing=False)
    yield made
    made.close()


class Page:
    """What a page does: it asks, gets answers, and keeps the newest picture."""

    def __init__(self, address: str) -> None:
        url = address.replace("http", "ws", 1).replace("/?", "/socket?")
        self._open = connect(url, origin=address.split("/?")[0], max_size=None, close_timeout=1)
        self.socket: ClientConnection = self._open.__enter__()
        self.pictures: list[dict[str, Any]] = []
        self.number = 0

    def close(self) -> None:
        self._open.__exit__(None, None, None)

    def ask(self, **request: Any) -> dict[str, Any]:
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, **request}))
        while True:
            message = self.socket.recv(PATIENCE)
            found = json.loads(message) if isinstance(message, str) else unpack(message)
            if found.get("id") == self.number:
                return found
            self.pictures.append(found)

    def until(self, true: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            message = self.socket.recv(PATIENCE)
            found = json.loads(message) if isinstance(message, str) else unpack(message)
            if found["kind"] == "live" and true(found):
                return found
        raise AssertionError("it never came")


@pytest.fixture
def page(running: Live) -> Iterator[Page]:
    made = Page(running.address)
    yield made
    made.close()


def test_the_scene_has_inputs_and_parameters(page: Page) -> None:
    scene = page.ask(ask="scene")
    assert scene["what"] == "live"
    (torque,) = scene["inputs"]
    assert (torque["name"], torque["unit"], torque["value"]) == ("torque", "N m", 0.0)
    assert torque["low"] < 0 < torque["high"]
    (load,) = scene["parameters"]
    assert load == {"name": "load", "value": 2.0, "unit": "kg", "low": 1.0, "high": 5.0}


def test_orders_of_the_page_move_the_machine(page: Page, running: Live) -> None:
    page.ask(do="set", name="torque", value=3.0)
    page.ask(do="step")
    picture = page.until(lambda p: p["time"] > 0.0)
    assert picture["time"] == pytest.approx(0.01)
    assert not picture["playing"]
    np.testing.assert_allclose(picture["sensors"], picture["row"][:3], rtol=1e-6, atol=1e-6)
    page.ask(do="play")
    page.until(lambda p: p["playing"] and p["time"] > 0.1)
    page.ask(do="pause")
    page.until(lambda p: not p["playing"])
    page.ask(do="reset")
    assert running.time == 0.0


def test_a_page_pulls_the_vertex_that_it_grips(page: Page, running: Live) -> None:
    scene = page.ask(ask="scene")
    k = [body["name"] for body in scene["bodies"]].index("bob")
    vertices = scene["bodies"][k]["positions"]
    vertex = int(np.argmin(np.linalg.norm(vertices, axis=1)))
    page.ask(do="speed", value=0)
    page.ask(do="pull", body=k, vertex=vertex, point=[1.0, 0.0, -0.5])
    page.ask(do="play")
    picture = page.until(lambda p: p["time"] > 30.0)
    page.ask(do="pause")
    grip = running.runner.machine.inputs
    assert grip["hand body"] == 0.0
    # at rest the pull and the weight have no moment about the pivot: r x (k (x - r) + m g) = 0
    q = np.array(running.now.q)
    r = point_position(running.runner.machine.model, q, 0, vertices[vertex].astype(float))
    force = grip["hand stiffness"] * (np.array([1.0, 0.0, -0.5]) - r)
    moment = np.cross(r, force) + np.cross(q[:3], [0.0, 0.0, -2 * 9.81])
    # without friction the pendulum swings until the damper has taken all: 30 s are many times that
    assert abs(moment[1]) < 1e-3 * np.linalg.norm(force)
    assert r[0] > 0.1
    page.ask(do="release")
    page.ask(do="step")
    assert running.runner.machine.inputs["hand body"] == -1.0
    assert picture["kind"] == "live"


@pytest.mark.parametrize(
    ("order", "sentence"),
    [
        ({"do": "fly"}, "do is 'fly'"),
        ({"do": "set", "name": "toque", "value": 1}, "no input 'toque'"),
        ({"do": "set", "name": "torque", "value": "much"}, "must be a number"),
        ({"do": "pull", "body": 99, "vertex": 0, "point": [0, 0, 0]}, "body is 99"),
        ({"do": "pull", "body": 0, "vertex": 0, "point": [0, 0]}, "three numbers"),
        ({"do": "speed", "value": -1}, "speed is -1"),
        ({"do": "parameter", "name": "lod", "value": 1}, "no parameter 'lod'"),
        ({"do": "parameter", "name": "load", "value": -3}, "mass is -3 kg"),
        ({"ask": "window", "start": 0, "end": 1}, "window"),
    ],
)
def test_what_a_page_gets_wrong_is_a_sentence(
    page: Page, running: Live, order: dict[str, Any], sentence: str
) -> None:
    answer = page.ask(**order)
    assert answer["kind"] == "error" or order.get("ask")
    if answer["kind"] == "error":
        assert sentence in answer["message"]
    page.ask(do="step")  # it lives
    assert running.time > 0.0


def test_a_parameter_changes_the_machine_which_goes_on(page: Page, running: Live) -> None:
    page.ask(do="set", name="torque", value=3.0)
    for _ in range(20):
        page.ask(do="step")
    then, q = running.time, running.now.q.copy()
    first = running.runner.machine.model.bodies[0].mass[0]
    page.ask(do="parameter", name="load", value=4.0)
    assert (first, running.runner.machine.model.bodies[0].mass[0]) == (2.0, 4.0)
    assert running.time == then
    np.testing.assert_allclose(running.now.q, q, rtol=0, atol=1e-12)
    scene = page.ask(ask="scene")
    assert scene["parameters"][0]["value"] == 4.0
    assert scene["inputs"][0]["value"] == 3.0
    page.ask(do="step")
    assert page.until(lambda p: p["scene"] == 2)["message"] == ""


def test_the_page_records_beside_files_that_exist(page: Page, tmp_path: Path) -> None:
    (tmp_path / "swing-live.h5").write_text("mine")
    page.ask(do="record", on=True)
    for _ in range(5):
        page.ask(do="step")
    picture = page.until(lambda p: p["recording"])
    assert picture["recording"] == "swing-live-2.h5"
    page.ask(do="record", on=False)
    assert jo.load(tmp_path / "swing-live-2.h5").nt == 6
    assert (tmp_path / "swing-live.h5").read_text() == "mine"


def test_two_pages_see_the_same_machine(page: Page, running: Live) -> None:
    other = Page(running.address)
    page.ask(do="set", name="torque", value=1.5)
    page.ask(do="step")
    assert other.until(lambda p: p["time"] > 0.0)["time"] == pytest.approx(0.01)
    assert other.ask(ask="scene")["inputs"][0]["value"] == 1.5
    other.close()
    page.ask(do="step")


def test_a_probe_answers_about_this_instant(page: Page, running: Live) -> None:
    scene = page.ask(ask="scene")
    k = [body["name"] for body in scene["bodies"]].index("bob")
    page.ask(do="set", name="torque", value=5.0)
    for _ in range(10):
        page.ask(do="step")
    found = page.ask(ask="probe", body=k, vertex=0, time=0.0)
    point = scene["bodies"][k]["positions"][0].astype(float)
    exact = point_position(running.runner.machine.model, running.now.q, 0, point)
    np.testing.assert_allclose(found["position"], exact, atol=1e-6)  # vertices have 7 digits
    assert found["time"] == pytest.approx(0.1)


def test_closing_ends_all_threads(model: Path) -> None:
    before = {thread.name for thread in threading.enumerate()}
    made = live(model, open=False, record="run.h5")
    page = Page(made.address)
    page.until(lambda p: p["time"] > 0.05)
    made.close()
    made.close()
    names = {t.name for t in threading.enumerate()} - before
    assert not {"jousto-live", "jousto-pictures", "jousto-recorder"} & names
    assert jo.load("run.h5").complete
    assert "closed" in repr(made)


def test_a_mechanism_and_a_model_run_too() -> None:
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Input("force", 8.0))
    mechanism = jo.Mechanism(cart, rail, push)
    for thing in (mechanism, jo.compile(mechanism)):
        made = jo.live(thing, open=False, speed=0, step=1e-3, playing=False)
        made.runner.step()
        # x = f t^2 / 2 m
        assert made.now.q[0] == pytest.approx(0.5 * 4.0 * 0.01**2, rel=1e-9)
        made.set("force", 0.0)
        made.pull("cart", (0, 0, 0), (1, 0, 0))
        made.release()
        with pytest.raises(jo.InputError, match="no body 'card'; there are cart"):
            made.pull("card", (0, 0, 0), (1, 0, 0))
        made.close()


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"machine": 3}, "machine is a int"),
        ({"step": -1.0}, "step is -1 s"),
        ({"speed": -1.0}, "speed is -1"),
        ({"port": 1e9}, "port is"),
        ({"ranges": {"tork": (0, 1)}}, "no input 'tork'"),
    ],
)
def test_wrong_arguments_are_sentences(model: Path, given: dict[str, Any], sentence: str) -> None:
    before = threading.active_count()
    with pytest.raises(jo.InputError, match=sentence):
        live(**{"machine": model, "open": False, **given})
    assert threading.active_count() == before


def test_a_page_that_reads_nothing_does_not_slow_the_machine(running: Live) -> None:
    """Pictures for a page that does not read them are dropped, not kept, and stop nobody."""
    address = urlsplit(running.address)
    deaf = socket.socket()
    deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    deaf.connect((address.hostname, address.port))
    deaf.sendall(
        f"GET /socket?{address.query} HTTP/1.1\r\nHost: {address.netloc}\r\n"
        f"Origin: http://{address.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    assert deaf.recv(12) == b"HTTP/1.1 101"
    page = Page(running.address)
    # far more pictures than the buffers of a connection hold
    picture, pushed = pack({"kind": "live", "time": 0.0, "more": np.zeros(1 << 17)}), 64
    for _ in range(pushed):
        running._server.push(picture)
        page.ask(do="pause")  # one after the other
    page.ask(do="play")
    # the machine runs, the other page sees it, and both are answered
    page.until(lambda p: p["time"] > 2.0)
    page.ask(do="pause")
    client = min(running._server._clients, key=lambda c: c.number)
    waits = client.connection.transport.get_write_buffer_size()
    assert 0 < waits < 4 * len(picture)  # some of one or two pictures
    page.close()
    deaf.close()


def test_damage_grows_as_in_a_run_of_the_same_steps() -> None:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.025), 4, jo.Material(E=2e11, nu=0.3, rho=7850))
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=3)))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], (0, 1, 0))
    stress = jo.StressSensor("stress", arm, "e1.a.top")
    steel = jo.SN(100e6, 1e6, 5.0, "elementary")
    worn = jo.mechanism.DamageSensor(
        "worn", stress, steel, residue="half", components=("e1.a.top:s11",)
    )
    gravity = jo.Gravity((0, 0, -9.81))
    model = jo.compile(jo.Mechanism(arm, pin, gravity, stress, worn, name="falling"))
    solver = jo.GeneralizedAlpha(step=1e-3)
    machine = LiveMachine(model, solver)
    runner = Runner(machine, speed=0, playing=False)
    desk = LiveDesk(
        OpenedMachine(model, solver), runner, step=None, ranges={}, record=Path("no.h5")
    )
    grown = []
    for _ in range(30):
        runner.step()
        (found,) = desk.live(runner.glance)["damage"]
        grown.append(found["value"])
    runner.close()
    run = jo.simulate(model, 0.3, solver=solver, output_step=0.01)
    assert found["name"].startswith("worn")
    assert grown[-1] > grown[5] > 0.0
    # the hand adds forces that are zero: the same numbers, to the rounding of one step in 300
    np.testing.assert_allclose(grown, run["worn"][1:, 0], rtol=1e-6)
