"""Machines beside hardware: frames by datagrams and shared memory, in C and in Python."""

from __future__ import annotations

import mmap
import shutil
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, WARNINGS
from jousto.simulation.live.datagrams import Datagrams, output_names
from jousto.simulation.live.frame import HEAD, INPUTS, OUTPUTS, Received, mark_of, pack
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.runner import Runner

STEP, STEPS = 1e-3, 200
in_c = pytest.mark.skipif(
    CC is None or sys.platform == "win32" or shutil.which("make") is None, reason="no C compiler"
)


def pushed() -> jo.Model:
    """Return a driven pendulum with two inputs, a position, and an angle."""
    rod = jo.RigidBody("rod", 2.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], rod["origin"], axis=(0, 1, 0))
    motor = jo.JointForce("motor", pin.angle, jo.Input("torque", 0.5))
    spring = jo.Spring("spring", pin.angle, 20.0, 0.5)
    wind = jo.Force("wind", rod.at((1.0, 0, 0)), (0, 0, 1), signal=jo.Input("wind"))
    tip = jo.PositionSensor("tip", rod.at((1.0, 0, 0)))
    angle = jo.CoordinateSensor("angle", pin.angle)
    gravity = jo.Gravity((0, 0, -9.81))
    return jo.compile(jo.Mechanism(rod, pin, motor, spring, wind, tip, angle, gravity))


def law(t: float) -> list[float]:
    return [3.0 * np.sin(20.0 * t), np.cos(9.0 * t)]


@cache
def wanted(model: jo.Model) -> np.ndarray:
    """Return time and sensors after each step of `simulate`, one run for each held input."""
    rows = []
    state = None
    for k in range(STEPS):
        held = dict(zip(model.inputs, law(k * STEP), strict=True))
        run = jo.simulate(
            model, STEP * (k + 1), state=state, inputs=held, solver=jo.ROS2(STEP), output_step=STEP
        )
        state = run.state(-1)
        rows.append(
            np.concatenate([run.time[-1:], *(run[s.name][-1].ravel() for s in model.sensors)])
        )
    return np.array(rows)


@pytest.fixture(scope="module")
def model() -> jo.Model:
    return pushed()


@pytest.fixture(scope="module")
def built(model: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hardware")
    jo.write(model, folder / "arm.zip", solver=jo.ROS2(STEP))
    shutil.unpack_archive(folder / "arm.zip", folder)
    sanitize = "-fsanitize=address,undefined -fno-sanitize-recover=all"
    flags = " ".join([*WARNINGS[1:], "-O0", sanitize])
    line = ["make", "arm_hardware", f"CFLAGS={flags}"]
    done = subprocess.run(line, cwd=folder / "arm", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "arm" / "arm_hardware"


@contextmanager
def running(*line: object) -> Iterator[tuple[subprocess.Popen[str], str]]:
    with subprocess.Popen(
        [str(x) for x in line], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            yield process, process.stdout.readline().strip()
        finally:
            process.terminate()


def names(model: jo.Model) -> int:
    return mark_of(model.inputs, output_names(model))


class Peer:
    """Hardware: sends inputs, waits for outputs."""

    def __init__(self, model: jo.Model, port: int) -> None:
        self.mark = names(model)
        self.received = Received(OUTPUTS, self.mark, len(output_names(model)))
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(20.0)
        self.to = ("127.0.0.1", port)

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def send(self, frame: bytes) -> None:
        self.socket.sendto(frame, self.to)

    def exchange(self, k: int, values: list[float]) -> np.ndarray:
        self.send(pack(INPUTS, self.mark, k, 0.0, values))
        found = self.received.read(self.socket.recv(65536))
        assert found is not None
        return np.array([self.received.time, *found])


def port_of(said: str) -> int:
    return int(said.rpartition(":")[2])


def close_to(found: np.ndarray, model: jo.Model) -> None:
    # the compiler's sums and those of the engine on this processor may differ in round-off
    np.testing.assert_allclose(found, wanted(model), rtol=0, atol=1e-10)


@in_c
def test_a_peer_drives_the_program_by_datagrams(model: jo.Model, built: Path) -> None:
    with running(built, "udp", 0) as (process, said), Peer(model, port_of(said)) as peer:
        rows = []
        for k in range(STEPS):
            if k == 50:  # none of these is taken, nor makes a step
                good = pack(INPUTS, peer.mark, k, 0.0, law(0.0))
                for bad in (
                    b"",
                    good[:-1],
                    good + b"0",
                    b"x" + good[1:],
                    good[:4] + b"\2" + good[5:],
                ):
                    peer.send(bad)
                peer.send(pack(INPUTS, peer.mark ^ 1, k, 0.0, law(0.0)))
                peer.send(pack(INPUTS, peer.mark, k, 0.0, [np.nan, 0.0]))
                peer.send(pack(INPUTS, peer.mark, 3, 0.0, law(0.0)))
                peer.send(pack(INPUTS, peer.mark, 2**64 - 1, 0.0, law(0.0)))  # forged
            number = k if k < 100 else k + 7  # seven are lost
            rows.append(peer.exchange(number, law(k * STEP)))
        process.terminate()
        assert process.stdout is not None
        assert process.stdout.read().strip() == (
            f"{STEPS} steps, frames: {STEPS} taken, 7 lost, 2 old, 7 wrong"
        )
    assert process.returncode == 0 and peer.received.lost == 0
    close_to(np.array(rows), model)


@in_c
def test_a_peer_drives_the_program_by_shared_memory(
    model: jo.Model, built: Path, tmp_path: Path
) -> None:
    path, mark, count = tmp_path / "shared", names(model), len(output_names(model))
    size = HEAD.size + 8 * len(model.inputs)
    with running(built, "shared", path) as (_, said), open(path, "r+b") as file:
        assert said == f"sharing {path}"
        with mmap.mmap(file.fileno(), 0) as shared:
            assert len(shared) == 16 + size + HEAD.size + 8 * count
            received, rows = Received(OUTPUTS, mark, count), []
            for k in range(STEPS):
                shared[:8] = struct.pack("<Q", 2 * k + 1)
                shared[8 : 8 + size] = pack(INPUTS, mark, k, 0.0, law(k * STEP))
                shared[:8] = struct.pack("<Q", 2 * k + 2)
                end = time.monotonic() + 20.0
                while struct.unpack_from("<Q", shared, 8 + size)[0] != 2 * k + 2:
                    assert time.monotonic() < end
                    time.sleep(1e-5)
                values = received.read(shared[16 + size :])
                assert values is not None
                rows.append([received.time, *values])
    close_to(np.array(rows), model)


@pytest.mark.parametrize("far", [2**64 - 1, 2**63, 10_000])
def test_one_frame_from_far_away_does_not_end_a_link(far: int) -> None:
    """RFC 3550, A.1: a leap counts once the next frame goes on from it."""
    reader = Received(INPUTS, 7, 1)
    take = lambda k: reader.read(pack(INPUTS, 7, k, 0.0, [1.0])) is not None  # noqa: E731
    assert [take(k) for k in (5, 6, far, 7, far, 8)] == [True, True, False, True, False, True]
    assert (reader.old, reader.lost) == (2, 0)
    # a sender that begins anew elsewhere is followed from its second frame on
    assert [take(far), take((far + 1) % 2**64), take((far + 2) % 2**64)] == [False, True, True]


def test_numbers_go_on_from_the_last_to_the_first() -> None:
    reader = Received(INPUTS, 7, 1)
    numbers = [2**64 - 2, 2**64 - 1, 0, 1, 3]
    assert all(reader.read(pack(INPUTS, 7, k, 0.0, [1.0])) is not None for k in numbers)
    assert (reader.taken, reader.old, reader.lost) == (5, 0, 1)


def test_a_live_machine_in_python_takes_the_same_frames(model: jo.Model) -> None:
    machine = LiveMachine(model, jo.ROS2(STEP), interval=STEP)
    link = Datagrams(machine, 0)
    rows = []
    with Peer(model, link.port) as peer:
        for k in range(STEPS):  # in lockstep, so that the trajectory is known
            peer.send(pack(INPUTS, peer.mark, k, 0.0, law(k * STEP)))
            while link.received.taken <= k:
                link.before(machine)
            machine.step()
            link.after(machine)
            found = peer.received.read(peer.socket.recv(65536))
            assert found is not None
            rows.append([peer.received.time, *found])
    link.close()
    close_to(np.array(rows), model)


def test_a_runner_sends_a_frame_each_step(model: jo.Model) -> None:
    machine = LiveMachine(model, jo.ROS2(STEP), interval=STEP)
    link = Datagrams(machine, 0)
    runner = Runner(machine, link=link)
    times = []
    with Peer(model, link.port) as peer:
        peer.send(b"nonsense")
        peer.send(pack(INPUTS, peer.mark, 0, 0.0, [2.0, 0.0]))
        while len(times) < 20:
            assert peer.received.read(peer.socket.recv(65536)) is not None
            times.append(peer.received.time)
    runner.close()
    np.testing.assert_allclose(np.diff(times), STEP, atol=1e-12)
    assert (link.received.taken, link.received.wrong) == (1, 1)
    assert runner.glance.inputs["torque"] == 2.0


def test_a_port_that_is_taken(model: jo.Model) -> None:
    machine = LiveMachine(model, jo.ROS2(STEP), interval=STEP)
    first = Datagrams(machine, 0)
    with pytest.raises(
        jo.InputError, match=f"udp: port {first.port} of 127.0.0.1 cannot be opened"
    ):
        Datagrams(machine, first.port)
    first.close()
