"""Twins as programs of C tell what monitors tell, and refuse memories that are not theirs."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, WARNINGS
from measurement.twin.crane import boom

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)

CLOSE = 1e-9
"""Of the largest stress: both sum the same products, in another order; measured 1e-12 and less."""
SANITIZE = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
STEP = 1e-3
SPOTS = ["e1.a.bottom", "e3.a.top", "e6.a.left"]


@pytest.fixture(scope="module")
def rod() -> jo.ReducedPart:
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, steel)
    free = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=3))
    return jo.reduction.clamp(free, "start")


@pytest.fixture(scope="module")
def gauges(rod: jo.ReducedPart) -> list[jo.gauges.Gauge]:
    # both bendings, stretch and torsion: along the edges and, on top, at 45 degrees
    places = [("e1.a", "top"), ("e1.a", "left"), ("e1.a", "bottom"), ("e4.a", "top")]
    places += [("e4.a", "right"), ("e7.a", "top_left"), ("e9.a", "top"), ("e9.a", "left")]
    return [jo.gauges.Gauge(f"g{k}", rod, ".".join(at)) for k, at in enumerate(places)]


def record(rod: jo.ReducedPart, B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return times and strains of a tip that is pulled about, with everything that goes wrong."""
    rng = np.random.default_rng(3)
    keep = np.r_[0:150, 157:400]
    t = STEP * keep
    force = np.stack([30.0 * np.sin(40.0 * t), 20.0 * np.cos(23.0 * t), 400.0 * t], axis=1)
    p = force[:, [2, 0, 1]] @ rod.modes[rod.node("end")] / rod.stiffness
    e = p @ B.T + 1e-6 * rng.standard_normal((len(t), len(B)))
    e[40:60, 2] = np.nan
    e[90] = np.nan
    e[120, 5] = 0.02  # saturated
    e[200:280, 1] = e[200, 1]  # stuck
    e[300, 6] += 4e-3  # a spike
    return t, e


def observer(
    rod: jo.ReducedPart, gauges: list[jo.gauges.Gauge], **options: object
) -> jo.twin.Observer:
    loads = [
        jo.twin.UnknownLoad("end", "fx fy fz", rate=2e3, size=100.0, smooth=True),
        jo.twin.UnknownLoad("end", "my", rate=50.0, size=1.0, mean=0.1),
    ]
    given = {"noise": 1e-6, "discrepancy": 2e-6} | options
    return jo.twin.Observer(rod, gauges, loads=loads, step=STEP, **given)


def moving(rod: jo.ReducedPart) -> jo.twin.Reference:
    t = np.linspace(0.0, 0.5, 60)
    a = np.stack([2.0 * np.sin(9 * t), np.cos(5 * t), 9.81 + 0 * t], axis=1)
    return jo.twin.Reference(t, a, 3.0 * a, 20.0 * a[::-1])


def build(monitor: jo.monitor.Monitor, folder: Path) -> Path:
    jo.write(monitor, folder / "twin.c")
    out = folder / "twin"
    line = [str(CC), *WARNINGS, *SANITIZE, "-DMAIN", "twin.c", "-o", str(out), "-lm"]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out


def table(path: Path, twin: jo.twin.Observer | None, t: np.ndarray, e: np.ndarray) -> Path:
    rows = np.column_stack([t, e])
    first = 1 if twin is not None and twin.gauge_names[0] == "g1" else 0
    names = ["time [s]", *(f"g{first + k} [m/m]" for k in range(e.shape[1]))]
    if twin is not None and twin.reference is not None:
        motion = [np.concatenate(twin.reference.at(s)) for s in t]
        rows = np.column_stack([rows, motion])
        names += [f"{what}.{axis}" for what in ("acceleration", "w", "dw") for axis in "xyz"]
    lines = [",".join(names), *(",".join(repr(float(x)) for x in row) for row in rows)]
    path.write_text("\n".join(lines).replace("nan", "") + "\n")
    return path


def run(program: Path, *arguments: Path) -> np.ndarray:
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return np.array([[float(x) for x in row.split(",")] for row in done.stdout.splitlines()[1:]])


CURVE = jo.SN(S_D=5e6, N_D=1e5, k=5, T_S=1.2)


def watching(
    twin: object, rod: jo.ReducedPart, criterion: str, **more: object
) -> jo.monitor.Monitor:
    given = {"sn": CURVE, "every": 0.1, "mean": jo.fatigue.Goodman(S_u=4e8)} | more
    return jo.monitor.Monitor(twin, rod, SPOTS, criterion=criterion, **given)


def compare(program: Path, folder: Path, watch: jo.monitor.Monitor, twin: object, t, e) -> None:
    found = run(
        program, table(folder / "samples.csv", getattr(twin, "system", None) and twin, t, e)
    )
    told = watch.push(t, e)
    spots = found[:, 1:19].reshape(len(t), 3, 6)
    size = np.nanmax(np.abs(told.high), axis=0)
    for k, wanted in enumerate((told.stress, told.low, told.high)):
        assert np.array_equal(np.isnan(spots[:, :, k]), np.isnan(wanted))
        assert np.nanmax(np.abs(spots[:, :, k] - wanted) / size) < CLOSE
    life = watch.life
    assert life is not None and (life.damage > 0.0).all()
    for k, wanted in enumerate((life.damage, life.damage_low, life.damage_high)):
        np.testing.assert_allclose(spots[-1, :, 3 + k], wanted, rtol=1e-7)  # to the tenth power
    assert found[-1, 19] == pytest.approx(life.watched, rel=1e-12)


@pytest.mark.parametrize(
    "criterion",
    ["max-shear", *(pytest.param(x, marks=pytest.mark.slow) for x in ("s11", "signed-von-mises"))],
)
def test_an_observer_tells_in_c_what_it_tells_in_python(
    rod: jo.ReducedPart, gauges: list[jo.gauges.Gauge], tmp_path: Path, criterion: str
) -> None:
    """Dead, stuck, saturated and wild gauges, a pause, a frame that moves, errors that stay."""
    errors = jo.twin.gauge_errors(gauges, factor=0.01, position=1e-3)
    twin = observer(rod, gauges, reference=moving(rod), gate=5.0, errors=errors)
    assert 0 < twin.system.nd < rod.n, "some modes move, some follow"
    watch = watching(twin, rod, criterion, scale=0.02)
    program = build(watch, tmp_path)
    t, e = record(rod, twin.B)
    compare(program, tmp_path, watch, twin, t, e)


def test_loads_that_balance_a_moving_boom(tmp_path: Path) -> None:
    """The floating boom of the crane, whose loads support its weight and inertia."""
    part = boom(False)
    rows = stress_rows(part, "e2.a.top e2.a.left e3.a.bottom e3.a.right e5.a.top_left e7.a.left")
    loads = [
        jo.twin.UnknownLoad("start", "fx fy fz mz", rate=2e4, size=3e4, smooth=True),
        jo.twin.UnknownLoad("node4", "fx fz", rate=3e4, size=5e4, smooth=True),
        jo.twin.UnknownLoad("end", "fx fy fz mx my mz", rate=2e4, size=2e4, smooth=True),
    ]
    given = {"noise": 2e-6, "discrepancy": 3e-6, "balance": jo.twin.Balance(60.0, 40.0)}
    reference = moving(part)
    twin = jo.twin.Observer(part, rows, loads=loads, step=0.01, reference=reference, **given)
    t = 0.01 * np.r_[0:30, 33:60]
    e = 1e-4 * np.sin(np.outer(9.0 * t, np.arange(1, 7)))
    e[20:25, 3] = np.nan
    watch = jo.monitor.Monitor(twin, part, SPOTS, criterion="s11", sn=CURVE, every=0.1)
    compare(build(watch, tmp_path), tmp_path, watch, twin, t, e)


def stress_rows(part: jo.ReducedPart, sites: str) -> np.ndarray:
    assert part.stress is not None
    index = [part.stress.labels.index(site) for site in sites.split()]
    return part.stress.modes[index, 0] / 2.1e11


@pytest.mark.parametrize("prior", [None, 1e-3])
def test_samples_each_alone(
    rod: jo.ReducedPart, gauges: list[jo.gauges.Gauge], tmp_path: Path, prior: float | None
) -> None:
    """Without a prior the stress is unknown where too few gauges are left."""
    kept = rod.keep(rod.in_plane("xz"))
    B = jo.gauges.gauge_rows(gauges, rod)[:, rod.in_plane("xz")]
    errors = np.abs(B)[None] * 0.01
    names = tuple(g.name for g in gauges)
    twin = jo.twin.Reconstruction(B, noise=1e-6, prior=prior, names=names, errors=errors)
    watch = watching(twin, kept, "signed-von-mises")
    program = build(watch, tmp_path)
    t, e = record(kept, B)
    e[95:100, :5] = np.nan
    compare(program, tmp_path, watch, twin, t, e)


def test_a_twin_goes_on_after_a_power_cut_to_the_last_bit(
    rod: jo.ReducedPart, gauges: list[jo.gauges.Gauge], tmp_path: Path
) -> None:
    twin = observer(rod, gauges, gate=6.0)
    program = build(watching(twin, rod, "s11"), tmp_path)
    t, e = record(rod, twin.B)
    whole = run(program, table(tmp_path / "all.csv", twin, t, e))
    memory = tmp_path / "memory"
    cuts = [0, 50, 91, 152, len(t)]
    parts = [
        run(program, table(tmp_path / "part.csv", twin, t[a:b], e[a:b]), memory)
        for a, b in zip(cuts[:-1], cuts[1:], strict=True)
    ]
    assert np.array_equal(np.concatenate(parts), whole)
    # half written, one bit changed, of another version, of another twin: refused, whatever it holds
    good = memory.read_bytes()
    other = good[:4] + (2).to_bytes(4, "little") + good[8:-4]
    another = good[:8] + bytes([good[8] ^ 1]) + good[9:-4]
    endless = good[:20] + b"\xff" * (len(good) - 24)
    wrong = [
        b"",
        good[:7],
        good[: len(good) // 2],
        good + b"0",
        good[:300] + bytes([good[300] ^ 4]) + good[301:],
    ]
    wrong += [x + zlib.crc32(x).to_bytes(4, "little") for x in (other, another, endless)]
    for damaged in wrong:
        memory.write_bytes(damaged)
        done = subprocess.run(
            [program, tmp_path / "part.csv", memory], capture_output=True, text=True
        )
        assert done.returncode == 3 and "no whole memory of this twin" in done.stderr
        assert memory.read_bytes() == damaged, "what is there is not overwritten"


@pytest.mark.skipif(shutil.which("make") is None, reason="no make")
def test_a_project_builds_and_lines_that_cannot_be_are_left_out(
    rod: jo.ReducedPart, gauges: list[jo.gauges.Gauge], tmp_path: Path
) -> None:
    twin = observer(rod, gauges)
    jo.write(watching(twin, rod, "s11", sn=None, mean=None), tmp_path / "rod.zip")
    shutil.unpack_archive(tmp_path / "rod.zip", tmp_path)
    flags = " ".join([*WARNINGS[1:], "-O0"])
    subprocess.run(
        ["make", f"CFLAGS={flags}"], cwd=tmp_path / "rod", check=True, capture_output=True
    )
    t, e = record(rod, twin.B)
    path = table(tmp_path / "samples.csv", twin, t[:6], e[:6])
    lines = path.read_text().splitlines()
    odd = [
        "0.0015," + lines[4].split(",", 1)[1],
        "garbage",
        "0.002,1,2",
        lines[2],
        "nan" + lines[5][5:],
    ]
    path.write_text("\n".join([*lines[:4], *odd, *lines[4:]]) + "\n")
    done = subprocess.run([tmp_path / "rod" / "rod", path], capture_output=True, text=True)
    assert "5 lines whose time does not go on by whole steps" in done.stderr
    assert [row.split(",")[0] for row in done.stdout.splitlines()[1:]] == [
        f"{x:.17g}" for x in t[:6]
    ]
    head = done.stdout.splitlines()[0].split(",")
    assert head[1] == "e1.a.bottom.stress (Pa)" and head[-1] == "end.my (N m)"
