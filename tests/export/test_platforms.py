"""Programs for other platforms, run here by Wine, by an emulator and as WebAssembly."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import STEP, engine_rows, swinging_arm
from jousto.export.program import program
from jousto.export.project import one_file
from jousto.export.toolchain import PLATFORMS, Platform, build

pytest.importorskip("ziglang")
pytestmark = pytest.mark.slow

WASM = Platform("wasm32-wasi", "wasm32-wasi", ".wasm", "", "")
WINE = next(
    (x for x in ("/usr/lib/wine/wine64", shutil.which("wine64")) if x and Path(x).exists()), ""
)


def by_wine(binary: Path) -> str:
    if not WINE:
        pytest.skip("no Wine here")
    environment = {**os.environ, "WINEPREFIX": str(binary.parent / "wine"), "WINEDEBUG": "-all"}
    exe = binary.with_suffix(".exe")
    shutil.copy(binary, exe)
    done = subprocess.run(
        [WINE, str(exe), "0.4", "10"], capture_output=True, text=True, env=environment, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def by_qemu(binary: Path) -> str:
    qemu = shutil.which("qemu-aarch64")
    root = Path("/usr/aarch64-linux-gnu")
    if qemu is None:
        pytest.skip("no emulator of aarch64 here")
    given = ["-L", str(root)] if root.exists() else []
    done = subprocess.run(
        [qemu, *given, str(binary), "0.4", "10"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def by_wasmtime(binary: Path) -> str:
    wasmtime = pytest.importorskip("wasmtime")
    out = binary.with_suffix(".csv")
    engine = wasmtime.Engine()
    linker = wasmtime.Linker(engine)
    linker.define_wasi()
    store = wasmtime.Store(engine)
    settings = wasmtime.WasiConfig()
    settings.argv = ["arm", "0.4", "10"]
    settings.stdout_file = str(out)
    store.set_wasi(settings)
    instance = linker.instantiate(store, wasmtime.Module.from_file(engine, str(binary)))
    try:
        instance.exports(store)["_start"](store)
    except wasmtime.ExitTrap as end:
        assert end.code == 0
    return out.read_text()


@pytest.mark.parametrize(
    ("platform", "run"),
    [
        (PLATFORMS["x86_64-windows"], by_wine),
        (Platform("aarch64-linux", "aarch64-linux-musl", ".so", "", ""), by_qemu),
        (WASM, by_wasmtime),
    ],
    ids=lambda x: x.name if isinstance(x, Platform) else "",
)
def test_other_platforms_compute_the_same_within_round_off(
    platform: Platform, run: Callable[[Path], str], tmp_path: Path
) -> None:
    """Their libraries of sines and square roots round otherwise, and friction sticks and slips."""
    made = program(jo.compile(swinging_arm()), jo.ROS2(step=STEP), name="arm")
    binary = tmp_path / "arm"
    build({"arm.c": one_file(made, "main.c")}, platform, binary, flags=("-DMAIN",))
    found = np.loadtxt(io.StringIO(run(binary)), delimiter=",", skiprows=1)
    expected = engine_rows(tmp_path, 0.4, 10)
    scale = np.abs(expected).max(axis=0)
    assert found.shape == expected.shape
    assert (np.abs(found - expected) <= 1e-9 * np.maximum(scale, 1.0)).all()
    print(f"{platform.name}: {np.max(np.abs(found - expected) / np.maximum(scale, 1e-30)):.1e}")
