"""Every command of `jousto --help` works in a process of its own.

Tests that share a process hide what a command forgets to import. The console blocks of the pages
run so already (test_docs.py); the commands that no page runs are run here, on the swing of
docs/fatigue.md.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from exported import CC
from hearing import hear
from jousto.cli.group import app
from test_docs import BLOCK, PAGES, ROOT, commands, run_command

RUN = {
    "schema": ("schema",),
    "stress": ("stress", "swing.h5", "arm", "--criterion", "s11"),
    "forces": ("forces", "cable.h5"),
    "contacts": ("contacts", "swing.h5"),
    "friction": ("friction", "swing.h5", "swing.h5"),
    "monitor": ("monitor", ROOT / "examples/monitor.yaml", "--gauges", "data.csv", "-o", "b.h5"),
    "multiaxial": ("multiaxial", "swing.h5", "arm", "--sn", "fat71", "--residue", "half"),
    "strain-life": ("strain-life", "swing.h5", "--material", "sae-1045", "--residue", "half"),
    "verify": ("verify", "swing.yaml", "--t-end", "10 ms"),
    "realtime": ("realtime", "swing.yaml", "--steps", "1000", "--ordinary"),
    "view": ("view", "swing.h5", "-o", "swing.html"),
    "fatigue": ("fatigue", "--duty", "week.yaml", "--sn", "fat71", "--residue", "half"),
    "fatigue of the block": ("fatigue", "--duty", "week.yaml"),
}
"""What is run of the commands that no page runs, and of those that pages run in one way only."""
INTERRUPTED = "live"
"""The command that ends with Ctrl-C alone."""
CABLE = """\
bodies:
  - name: cable
    type: beam
    points: [[0, 0, 0], [2 m, 0, 0]]
    elements: 4
    section: {type: circle, diameter: 12 mm}
    material: {E: 5 GPa, nu: 0.4, rho: 1300}
joints: [{type: fixed, name: clamp, a: ground.origin, b: cable.start}]
gravity: [0, 0, -9.81]
simulation: {t_end: 2 ms, output_step: 1 ms}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the swing, a cable, their results, a duty cycle and a record."""
    path = tmp_path_factory.mktemp("processes")
    page = (ROOT / "docs/fatigue.md").read_text(encoding="utf-8")
    (swing,) = [m[2] for m in BLOCK.finditer(page) if m[2].startswith("# swing.yaml\n")]
    (path / "swing.yaml").write_text(swing, encoding="utf-8")
    (path / "cable.yaml").write_text(CABLE)
    (path / "week.yaml").write_text("events: [{result: swing.h5, repeats: 10}]\n")
    quick = path / "quick"
    quick.write_text(f'#!/bin/sh\nexec {CC} "$@" -O0\n')
    quick.chmod(0o755)
    gauges = ",".join(f"g{k} [um/m]" for k in range(1, 7))
    lines = [f"{0.01 * k:.2f},{','.join(['1.5'] * 6)}" for k in range(20)]
    (path / "data.csv").write_text("\n".join([f"time [s],{gauges}", *lines, ""]))
    for model in ("swing", "cable"):
        code, text = run_command(["run", f"{model}.yaml", "-q"], path)
        assert code == 0, text
    return path


@pytest.mark.parametrize("name", RUN)
def test_a_command_works_in_its_own_process(name: str, folder: Path) -> None:
    # how long a step takes is not looked at: not optimised, its program is built in a quarter
    settings = {"CC": str(folder / "quick")} if name == "realtime" else {}
    code, text = run_command([str(word) for word in RUN[name]], folder, **settings)
    assert code == 0, text
    assert text.strip() and "internal error" not in text


def test_a_live_machine_works_in_its_own_process(folder: Path) -> None:
    words = [sys.executable, "-m", "jousto", "live", "swing.yaml", "--no-open", "--port", "0"]
    with subprocess.Popen(
        words, cwd=folder, preexec_fn=hear, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:
        assert process.stdout is not None
        said = ""
        for line in process.stdout:
            said += line.decode()
            if "http://" in said:  # the words before it end it, too, and then it has no address
                process.send_signal(signal.SIGINT)
                break
        said += process.stdout.read().decode()
    assert process.returncode == 0 and "http://" in said, said


def test_no_command_is_left_out() -> None:
    known = set(get_command(app).commands)  # type: ignore[attr-defined]
    pages = {name for page in PAGES for name in commands(page)}
    assert known - pages - {words[0] for words in RUN.values()} == {INTERRUPTED}
    assert len(known) > 30
