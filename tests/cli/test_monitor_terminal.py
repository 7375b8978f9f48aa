"""jousto monitor on a terminal: the table that is drawn anew, and Ctrl-C as it is typed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading

import pytest

from cli.test_monitor import ENV, MODEL
from hearing import hear
from jousto.measurement.monitor.record_reader import MonitorRecord
from measurement.monitor.watched import lines, motion

pty = pytest.importorskip("pty", reason="pseudo-terminals are of Unix")
HANGS = 900.0
"""Time after which the process is taken as hung, s."""


def test_a_table_is_drawn_and_ctrl_c_ends_it_clean(tmp_path):
    import fcntl
    import struct
    import termios

    model, pipe = tmp_path / "rod.yaml", tmp_path / "logger"
    model.write_text(MODEL)
    os.mkfifo(pipe)
    into = os.open(pipe, os.O_RDWR)  # does not wait for a reader
    keyboard, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
    seen = b""

    def read_until(what):
        """Wait for a text as long as the process lives, however busy the machine is."""
        nonlocal seen
        while what not in seen:
            try:
                more = os.read(keyboard, 65536)
            except OSError:  # the other side is closed
                more = b""
            if not more:
                break
            seen += more
        assert what in seen, seen.decode(errors="replace")

    def alone():
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)
        hear()

    process = subprocess.Popen(
        [sys.executable, "-m", "jousto", "monitor", str(model), "--gauges", str(pipe)],
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
        env={**ENV, "TERM": "xterm-256color", "COLUMNS": "120", "LINES": "40"},
        start_new_session=True,
        preexec_fn=alone,
    )
    os.close(terminal)
    # a process that hangs is ended, which ends the wait
    watchdog = threading.Timer(HANGS, process.kill)
    watchdog.start()
    try:
        t, _, e = motion(400)
        text = "\n".join(lines(t, e))
        os.write(into, text[: text.index("\n1.5,")].encode() + b"\ngarbage\n")
        read_until(b"invalid lines: 1")
        os.write(into, text[text.index("\n1.5,") + 1 : text.index("\n3,") + 1].encode())
        read_until(b": 2.990 s")  # a long path breaks the line before it
        os.write(keyboard, b"\x03")
        read_until(b"record in")
        assert process.wait() == 0
    finally:
        watchdog.cancel()
        process.kill()
        process.wait()
        os.close(into)
        os.close(keyboard)
    drawn = seen.decode(errors="replace")  # the echo of ^C may stand within a character
    for head in ("hot spot", "MPa now", "95 % band", "remaining life", "channels: all ok"):
        assert head in drawn
    assert re.search(r"e1\.a\.top .*\d+ \.\. \d+", drawn)
    # the cursor is hidden while the table is drawn, and there again at the end; the table is gone
    assert drawn.rindex("\x1b[?25h") > drawn.rindex("\x1b[?25l")
    last = drawn[drawn.rindex("\x1b[?25h") :]
    assert "stopped by Ctrl-C" in last
    assert "hot spot " not in last
    assert "Traceback" not in drawn
    found = MonitorRecord(tmp_path / "rod.monitor.h5")
    assert not found.complete
    assert len(found) == 300
