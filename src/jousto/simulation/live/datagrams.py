"""Datagrams: link of a live machine to hardware or another program, by frames over UDP."""

from __future__ import annotations

import contextlib
import socket
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.model.model import Model
from jousto.simulation.live.drag_spring import NAMES
from jousto.simulation.live.frame import INPUTS, OUTPUTS, Received, mark_of, pack
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.results.row_layout import columns

LARGEST = 65536  # largest size of a datagram, bytes
MOST = 64  # maximum number of datagrams read between two steps; more are read later


def output_names(model: Model) -> list[str]:
    """Return the names of the components of all sensors, equal to those of an exported machine."""
    return [
        sensor.name if sensor.count == 1 else f"{sensor.name}.{part}"
        for sensor in model.sensors
        for part in sensor.components
    ]


class Datagrams:
    """UDP link that receives inputs before each step and sends outputs after it.

    Parameters
    ----------
    machine : LiveMachine
        Live machine with a row at every step.
    port : int
        Port to listen to; 0 for any free port.
    host : str
        Network address of this computer; "127.0.0.1" accepts datagrams of this computer only.

    Attributes
    ----------
    port : int
    received : Received
        Reader of the frames with its statistics.

    Raises
    ------
    InputError
        If the port cannot be opened.
    """

    def __init__(self, machine: LiveMachine, port: int, host: str = "127.0.0.1") -> None:
        self.inputs = [name for name in machine.model.inputs if name not in NAMES]
        outputs = output_names(machine.model)
        mark = mark_of(self.inputs, outputs)
        self.received = Received(INPUTS, mark, len(self.inputs))
        found = {c.place: c for c in columns(machine.model)}
        sensors = machine.model.sensors
        first = found[f"sensors/{sensors[0].name}"].first if sensors else 0
        self._sensors = slice(first, first + len(outputs))
        self._sequence, self._peer, self._mark = 0, None, mark
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            message = f"port {port} of {host} cannot be opened: {error.strerror or error}"
            raise InputError(Problem("udp", message)) from None
        self._socket.setblocking(False)
        self.port = int(self._socket.getsockname()[1])

    def before(self, machine: LiveMachine) -> None:
        """Set the inputs of the machine to the newest received frame."""
        newest: Array | None = None
        for _ in range(MOST):
            try:
                frame, peer = self._socket.recvfrom(LARGEST)
            except OSError:  # no more datagrams
                break
            values = self.received.read(frame)
            if values is not None:
                newest, self._peer = values, peer
        if newest is not None:
            for name, value in zip(self.inputs, newest, strict=True):
                machine.set(name, value)

    def after(self, machine: LiveMachine) -> None:
        """Send the outputs to the sender of the last inputs."""
        peer: Any = self._peer
        if peer is None:
            return
        values = np.asarray(machine.row[self._sensors])
        frame = pack(OUTPUTS, self._mark, self._sequence, machine.time, values)
        self._sequence += 1
        with contextlib.suppress(OSError):  # receiver closed, or frame too large
            self._socket.sendto(frame, peer)

    def close(self) -> None:
        """Close the port."""
        self._socket.close()
