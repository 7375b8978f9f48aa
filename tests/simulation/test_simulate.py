"""simulate: schedule, results file, failures that keep what was computed."""

from __future__ import annotations

import errno
import faulthandler
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import warnings

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.simulation.results import writer as results
from jousto.simulation.running.simulate import describe
from jousto.simulation.solvers.stability import (
    body_eigenvalues,
    largest_stable_step,
    mechanism_eigenvalues,
    stability_warning,
)
from simulation.conftest import STEEL

# -- schedule -----------------------------------------------------------------------------------


def test_outputs_and_end_fall_on_steps(pendulum):
    run = jo.simulate(pendulum, 0.1, solver=jo.ROS2(3e-3), output_step=0.01)
    np.testing.assert_allclose(run.time, np.linspace(0, 0.1, 11), atol=1e-15)
    assert run.attributes["step"] == pytest.approx(0.0025)


def test_without_output_step_every_step_is_stored(pendulum):
    run = jo.simulate(pendulum, 0.1, solver=jo.ROS2(3e-3))
    assert run.nt == 35
    assert run.time[-1] == pytest.approx(0.1, abs=1e-15)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"t_end": -1.0}, "t_end is -1 s, must be a positive number"),
        ({"t_end": float("nan")}, "t_end is nan, must be finite"),
        ({"t_end": 1.0, "output_step": 0.3}, "not a multiple of output_step = 0.3 s"),
        ({"t_end": 1.0, "output_step": 0.0}, "output_step is 0 s"),
        (
            {"t_end": 1.0, "solver": "RK4"},
            "solver is 'RK4', must be one of DormandPrince, GeneralizedAlpha",
        ),
    ],
)
def test_impossible_schedules(pendulum, arguments, sentence):
    with pytest.raises(jo.InputError) as error:
        jo.simulate(pendulum, **arguments)
    assert sentence in str(error.value)


def test_a_mechanism_is_not_yet_a_model():
    body = jo.RigidBody("b", 1.0, (1, 1, 1), angular_velocity=(1, 0, 0))
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        mechanism = jo.Mechanism(body)
    with pytest.raises(jo.InputError, match="compile it first"):
        jo.simulate(mechanism, 1.0)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: jo.RK4(step=0.0), "step is 0.0, must be a positive number of seconds"),
        (lambda: jo.ROS2(step=float("inf")), "step is inf"),
        (lambda: jo.RK4(step="1e-3"), "step is '1e-3'"),
        (lambda: jo.RK4(1e-3, projection=1), "projection is 1, must be True or False"),
        (lambda: jo.RK4(1e-3, baumgarte=5.0), "baumgarte is 5.0, must be Baumgarte"),
        (lambda: jo.simulation.Baumgarte(-1.0, 1.0), "alpha is -1.0, must be 0 or more"),
    ],
)
def test_impossible_solvers(make, sentence):
    with pytest.raises(jo.InputError) as error:
        make()
    assert sentence in str(error.value)


# -- results ------------------------------------------------------------------------------------


def test_the_results_file_keeps_its_contract(pendulum, tmp_path):
    path = tmp_path / "run.h5"
    run = jo.simulate(pendulum, 0.05, output_step=0.01, path=path, model_text="name: pendulum\n")
    with h5py.File(path) as file:
        assert file.attrs["complete"] == 1
        assert file["time"].shape == (6,)
        assert file["state/q"].shape == (6, pendulum.nq)
        assert file["state/v"].shape == (6, pendulum.nv)
        assert file["state/multipliers"].shape == (6, 3)
        assert file["sensors/tip"].attrs["unit"] == "m"
        assert file["sensors/tip"].attrs["resolved_in"] == "world"
        assert "position of arm.end" in file["sensors/tip"].attrs["description"]
        assert file["model"].asstr()[()] == "name: pendulum\n"
        assert file["bodies/arm/nodes"].shape == (5, 3)
    assert run.model_text == "name: pendulum\n"
    assert jo.load(path).about("reaction")["components"][0] == "Fx"
    assert run.sensors == ("tip", "reaction")
    assert describe(run)["ended"] == "completed"


def test_unknown_sensors_get_a_suggestion(pendulum):
    run = jo.simulate(pendulum, 0.01)
    with pytest.raises(jo.InputError, match="no sensor 'tipp'; did you mean 'tip'"):
        run["tipp"]


def test_a_temporary_results_file_goes_with_its_solution(pendulum):
    run = jo.simulate(pendulum, 0.01)
    folder = run.path.parent
    assert folder.exists()
    del run
    assert not folder.exists()


@pytest.mark.parametrize(
    ("write", "sentence"),
    [
        (lambda p: p.write_bytes(b"not HDF5"), "damaged or of another kind"),
        (lambda p: h5py.File(p, "w").close(), "not a results file; it is some other HDF5 file"),
        (lambda p: None, "no such results file"),
    ],
)
def test_unreadable_results(tmp_path, write, sentence):
    path = tmp_path / "run.h5"
    write(path)
    with pytest.raises(jo.InputError) as error:
        jo.load(path)
    assert sentence in str(error.value)


def test_truncated_and_outdated_results(pendulum, tmp_path):
    path = tmp_path / "run.h5"
    jo.simulate(pendulum, 0.05, path=path)
    half = tmp_path / "half.h5"
    half.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(jo.InputError, match="damaged"):
        jo.load(half)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(jo.InputError, match="results format 99, this version reads 2"):
        jo.load(path)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("missing/run.h5", "does not exist; create it first"), (".", "is a folder, must be a file")],
)
def test_unwritable_places_are_refused_before_the_run(pendulum, tmp_path, name, sentence):
    with pytest.raises(jo.InputError) as error:
        jo.simulate(pendulum, 1.0, path=tmp_path / name)
    assert sentence in str(error.value)


# -- stability and divergence ---------------------------------------------------------------------


def test_a_step_too_large_for_rk4_is_predicted_and_diagnosed(pendulum, highest_frequency):
    step = 6.0 / (2 * np.pi * highest_frequency)
    with (
        pytest.warns(jo.JoustoWarning, match=r"will probably diverge: the mechanism has a mode of"),
        pytest.raises(
            jo.simulation.RunFailed, match=r"body 'arm' diverged; likely cause: .*RK4"
        ) as error,
    ):
        jo.simulate(pendulum, 1.0, solver=jo.RK4(step))
    assert 0.0 < error.value.time < 1.0
    assert error.value.body == "arm"
    solution = error.value.solution
    assert not solution.complete
    assert solution.nt > 2
    assert np.isfinite(solution.q).all()


def test_the_predicted_limit_is_sharp(pendulum):
    """Just below the limit the energy stays, just above it the run diverges."""
    eigenvalues = mechanism_eigenvalues(pendulum)
    omega = abs(eigenvalues).max()
    assert omega < abs(body_eigenvalues(pendulum, 0)).max()  # the joint lowers it
    limit = largest_stable_step(eigenvalues[abs(eigenvalues) > 100.0], jo.RK4(1.0), 1.0)
    assert limit * omega == pytest.approx(2 * np.sqrt(2), rel=1e-6)  # |R(iy)| = 1 of RK4
    run = jo.simulate(pendulum, 2000 * limit * 0.95, solver=jo.RK4(0.95 * limit))
    assert run.complete
    with pytest.warns(jo.JoustoWarning), pytest.raises(jo.simulation.RunFailed):
        jo.simulate(pendulum, 2000 * limit * 1.1, solver=jo.RK4(1.1 * limit))


def test_friction_that_sticks_is_no_mode(rod, highest_frequency):
    """Held or let go, it jumps at rest; the modes of the free hinge say how long steps may be."""
    arm = jo.FlexibleBody("arm", rod)
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["start"], axis=(0, 0, 1))
    sticks = {"preload": 10.0, "law": jo.mechanism.StickSlip()}
    friction = jo.Friction("brake", hinge, 0.2, 0.3, radius=0.05, **sticks)
    models = [jo.compile(jo.Mechanism(arm, hinge, *f, name="arm")) for f in ((), (friction,))]
    step = 6.0 / (2 * np.pi * highest_frequency)
    free, held = (stability_warning(model, jo.RK4(step), step) for model in models)
    assert "needs a step below" in free
    assert held == free


def test_ros2_runs_where_rk4_cannot(pendulum, highest_frequency):
    step = 6.0 / (2 * np.pi * highest_frequency)
    assert jo.simulate(pendulum, 0.5, solver=jo.ROS2(step)).complete


def test_an_inaccurate_run_is_pointed_out(pendulum):
    with (
        pytest.warns(jo.JoustoWarning, match="error of the energy balance"),
        pytest.warns(jo.JoustoWarning, match="joints opened by up to"),
    ):
        jo.simulate(pendulum, 9.0, solver=jo.ROS2(step=0.3))


# -- interruption ---------------------------------------------------------------------------------


def test_ctrl_c_keeps_a_valid_file(pendulum, tmp_path):
    def stop(now, wall):
        if now > 0.0:
            raise KeyboardInterrupt

    with pytest.raises(jo.simulation.RunInterrupted) as error:
        jo.simulate(pendulum, 1e4, path=tmp_path / "run.h5", progress=stop)
    run = jo.load(tmp_path / "run.h5")
    assert not run.complete
    assert run.attributes["ended"] == "interrupted"
    assert run.nt == error.value.solution.nt > 1


SCRIPT = """
    import sys
    import jousto as jo
    body = jo.RigidBody("rod", 2.0, (0.02, 0.2, 0.2), center=(1, 0, 0))
    pivot = jo.Spherical("p", jo.ground["origin"], body["origin"])
    gravity = jo.Gravity((0, 0, -9.81))
    tip = jo.PositionSensor("tip", body["center"])
    model = jo.compile(jo.Mechanism(body, pivot, gravity, tip))
    {limit}
    jo.simulate(model, 1e4, path=sys.argv[1], progress=lambda now, wall: print(now, flush=True))
"""


def start(tmp_path, limit=""):
    script = tmp_path / "run.py"
    script.write_text(textwrap.dedent(SCRIPT.format(limit=limit)))
    return subprocess.Popen(
        [sys.executable, str(script), str(tmp_path / "run.h5")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_killed_run_leaves_a_readable_file(tmp_path):
    process = start(tmp_path)
    for _ in range(8):
        reached = float(process.stdout.readline())
    running = jo.load(tmp_path / "run.h5")  # readable while it grows
    assert running.time[-1] > 0.0
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    process.stderr.close()
    run = jo.load(tmp_path / "run.h5")
    assert not run.complete
    assert run.time[-1] >= reached - 1e-9
    assert np.isfinite(run["tip"]).all()
    np.testing.assert_allclose(np.linalg.norm(run["tip"], axis=1), 1.0, atol=1e-10)


@pytest.mark.skipif(sys.platform == "win32", reason="no file size limit")
def test_no_room_for_the_results_is_said_before_the_run(tmp_path):
    limit = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))"
    )
    process = start(tmp_path, limit)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 1
    assert "InputError" in errors
    assert "cannot be written: File too large" in errors


def test_a_disk_that_fills_up_stops_the_run_with_a_sentence(pendulum, tmp_path, monkeypatch):
    real = results._write
    full = []

    def write(file, offset, data):
        if full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(file, offset, data)

    monkeypatch.setattr(results, "_write", write)
    with pytest.raises(
        jo.simulation.RunFailed, match="cannot write.*No space left.*free some space"
    ) as error:
        jo.simulate(
            pendulum, 1e3, path=tmp_path / "run.h5", progress=lambda now, wall: full.append(now)
        )
    run = jo.load(tmp_path / "run.h5")
    assert run.nt == error.value.solution.nt > 1
    assert run.attributes["ended"] == "running or killed"  # nothing could be written any more
    assert np.isfinite(run["tip"]).all()
    assert list(tmp_path.iterdir()) == [tmp_path / "run.h5"]


def test_a_run_that_ends_early_is_cut_to_its_length(pendulum, tmp_path):
    def stop(now, wall):
        raise KeyboardInterrupt

    with pytest.raises(jo.simulation.RunInterrupted):
        jo.simulate(pendulum, 1e4, path=tmp_path / "run.h5", progress=stop)
    with h5py.File(tmp_path / "run.h5") as file:
        assert len(file["time"]) == len(file["sensors/tip"]) == file["rows"][()] < 1e5
        np.testing.assert_allclose(np.diff(file["time"]), 1e-3, atol=1e-12)
    assert (tmp_path / "run.h5").stat().st_size < 1e8


def test_progress_reports_simulated_and_wall_time(pendulum):
    seen = []
    began = time.perf_counter()
    jo.simulate(pendulum, 0.5, progress=lambda now, wall: seen.append((now, wall)))
    took = time.perf_counter() - began
    times = [now for now, _ in seen]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(0.5)
    assert 0.0 < seen[-1][1] <= took


def test_the_bar_of_progress_true_goes_to_standard_error(pendulum, capsys):
    jo.simulate(pendulum, 0.1, progress=True)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "real time" in captured.err


# -- what else can go wrong -----------------------------------------------------------------------


def test_more_results_than_the_disk_holds_are_refused(pendulum, tmp_path):
    with pytest.raises(
        jo.InputError, match="instants need .* GB and .* GB are free; give a larger"
    ):
        jo.simulate(pendulum, 1e9, path=tmp_path / "run.h5")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"t_end": "abc"}, "t_end is 'abc', must be a number"),
        ({"t_end": None}, "t_end is nan"),
        ({"t_end": [1.0]}, "t_end has shape (1,)"),
        ({"t_end": 1e300}, "check the units of t_end, step and output_step"),
        ({"t_end": 1.0, "output_step": 1e-300}, "check the units"),
    ],
)
def test_odd_times_get_a_sentence(pendulum, arguments, sentence):
    with pytest.raises(jo.InputError) as error:
        jo.simulate(pendulum, **arguments)
    assert sentence in str(error.value)


def test_an_exception_of_the_progress_function_closes_the_file(pendulum, tmp_path, monkeypatch):
    def broken(now, wall):
        raise BrokenPipeError("nobody listens")

    with pytest.raises(BrokenPipeError, match="nobody listens"):
        jo.simulate(pendulum, 10.0, path=tmp_path / "run.h5", progress=broken)
    run = jo.load(tmp_path / "run.h5")
    assert run.attributes["ended"] == "failed: BrokenPipeError in the progress function"
    assert 1 < run.nt < 10_001
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(BrokenPipeError):
        jo.simulate(pendulum, 10.0, progress=broken)
    assert not list(tmp_path.glob("jousto-*"))


def test_a_solution_notices_that_its_file_was_overwritten(pendulum, tmp_path):
    first = jo.simulate(pendulum, 0.1, path=tmp_path / "run.h5")
    jo.simulate(pendulum, 0.2, path=tmp_path / "run.h5")
    with pytest.raises(jo.InputError, match="was overwritten by another run"):
        first["tip"]


def test_a_file_that_is_open_elsewhere_can_be_finished(pendulum, tmp_path):
    jo.simulate(pendulum, 0.1, path=tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5"):
        assert jo.simulate(pendulum, 0.2, path=tmp_path / "run.h5").complete


def read_everything(path):
    """What a child process does with a damaged file: 0 read or refused, 1 any other exception."""
    faulthandler.disable()
    signal.alarm(2)
    try:
        run = jo.load(path)
        for name in run.sensors:
            run[name], run.about(name)
        for name in ("q", "v", "multipliers", "energy", "residuals", "bodies", "model_text"):
            getattr(run, name)
    except jo.InputError:
        return 0
    except BaseException:
        return 1
    return 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_flipped_bytes_never_give_more_than_a_sentence(pendulum, tmp_path):
    # the HDF5 library itself falls over, or loops on, one damaged file in fifty: hence the children
    path = tmp_path / "run.h5"
    jo.simulate(pendulum, 0.01, path=path)
    whole = path.read_bytes()
    codes = []
    for seed in range(40):
        data = bytearray(whole)
        rng = np.random.default_rng(seed)
        for at in rng.integers(0, len(data), 30):
            data[at] = rng.integers(0, 256)
        path.write_bytes(data)
        child = os.fork()
        if child == 0:
            os._exit(read_everything(path))
        codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    assert max(codes) == 0
    assert sum(code < 0 for code in codes) <= 4


def test_thousands_of_stress_sites_fit(tmp_path):
    part = jo.Part.beam(10.0, jo.Rectangle(0.1, 0.2), 120, STEEL)
    body = jo.FlexibleBody("b", jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=2)))
    fixed = jo.Fixed("f", jo.ground["origin"], body["start"])
    mechanism = jo.Mechanism(body, fixed, jo.Gravity((0, 0, -9.81)), jo.StressSensor("s", body))
    run = jo.simulate(jo.compile(mechanism), 0.003, path=tmp_path / "run.h5")
    components = run.about("s")["components"]
    assert len(components) == run["s"].shape[1] > 10_000
    assert components[0].endswith(":s11")


def test_loads_faster_than_the_step_are_pointed_out(rod):
    arm = jo.FlexibleBody("arm", rod)
    pivot = jo.Spherical("pivot", jo.ground["origin"], arm["start"])
    fast = jo.Force("hum", arm["end"], (0, 1, 0), signal=jo.Harmonic(frequency=1000.0))
    pulse = jo.Force("pulse", arm["end"], (0, 0, 1), signal=jo.Table((0, 2e-4, 4e-4), (0, 1, 0)))
    model = jo.compile(jo.Mechanism(arm, pivot, fast, pulse))
    with (
        pytest.warns(jo.JoustoWarning, match="leave out 2.2 %"),
        pytest.warns(jo.JoustoWarning, match="'hum' oscillates with 1000 Hz"),
        pytest.warns(jo.JoustoWarning, match="'pulse' has table points 0.0002 s apart"),
        pytest.warns(jo.JoustoWarning, match="error of the energy balance"),
    ):
        jo.simulate(model, 0.002)


@pytest.mark.parametrize("times", ["steps", "shifted", "after"])
def test_a_table_with_points_at_the_steps_is_resolved(times, recwarn):
    """Differences of rounded instants lie beside the step; what is never passed is no gap."""
    at = {
        "steps": np.arange(21) * 1e-3,
        "shifted": 0.1 + np.arange(-101, 21) * 1e-3 - 0.1,
        "after": np.array([0.0, 0.01, 0.02, 0.0201, 0.0202]),
    }[times]
    cart = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Table(at, np.sin(at)))
    jo.simulate(jo.compile(jo.Mechanism(cart, rail, push)), 0.02, solver=jo.RK4(1e-3))
    assert not [str(x.message) for x in recwarn if "table points" in str(x.message)]


def test_round_off_is_no_energy_error():
    """A free top exchanges no energy; its balance is round-off of what it has."""
    top = jo.RigidBody("top", 1.0, (0.1, 0.2, 0.25), angular_velocity=(1, 2, 1))
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        mechanism = jo.Mechanism(top)
    assert jo.simulate(jo.compile(mechanism), 10.0, solver=jo.RK4(1e-3)).complete


@pytest.mark.filterwarnings("ignore:.*is not an interface")
def test_a_blow_up_is_not_taken_for_redundant_joints(rod):
    """Baumgarte terms far too stiff for the step tear a tree apart that has no redundancy."""
    a = jo.FlexibleBody("a", rod)
    b = jo.FlexibleBody("b", rod, position=(1, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            a,
            b,
            jo.Spherical("p", jo.ground["origin"], a["start"]),
            jo.Revolute("q", a["end"], b["start"], axis=(0, 0, 1)),
            jo.Gravity((0, -9.81, 1.0)),
        )
    )
    solver = jo.ROS2(1e-3, projection=False, baumgarte=jo.simulation.Baumgarte(47484.7, 47484.7))
    with (
        pytest.warns(jo.JoustoWarning, match="Baumgarte"),
        pytest.raises(
            jo.simulation.RunFailed, match="diverged; likely cause: .*Baumgarte"
        ) as error,
    ):
        jo.simulate(model, 1.0, solver=solver)
    assert (np.diff(error.value.solution.time) > 0).all()


# -- the state it starts from -------------------------------------------------------------------


def driven(speed: float) -> jo.Model:
    block = jo.RigidBody("block", 2.0, (0.1, 0.1, 0.1))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], (1, 0, 0))
    ramp = jo.Ramp(0.0, 10.0, before=0.0, after=10.0 * speed)
    return jo.compile(jo.Mechanism(block, slide, jo.Drive("belt", slide.displacement, ramp)))


@pytest.mark.filterwarnings("ignore:.*energy balance")
def test_a_state_at_rest_does_not_fit_a_drive_that_moves():
    model = driven(0.7)
    with pytest.warns(jo.JoustoWarning, match="do not fit 'belt' by 0.7 m/s") as caught:
        jo.simulate(model, 0.01, state=jo.equilibrium(model))
    (said,) = (str(one.message) for one in caught if "belt" in str(one.message))
    assert (
        "state=jo.simulation.vibration_free_state(model)" in said
        and "jo.simulation.steady_rotation(model, axis, speed)" in said
    )


def test_a_state_that_fits_is_taken_without_a_word():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = driven(0.0)
        rest = jo.equilibrium(model)
        still = jo.simulate(model, 0.01, state=rest)
        model = driven(0.7)
        moving = jo.simulate(
            model, 0.01, state=jo.simulation.State(model.q0, model.v0, np.zeros(model.nrow))
        )
    assert [str(w.message) for w in caught] == []
    np.testing.assert_array_equal(still.q[0], rest.q)
    np.testing.assert_array_equal(moving.v[0], model.v0)


def test_only_a_run_says_that_nothing_will_move():
    """A model made for its modes needs no forces."""
    still = jo.compile(jo.Mechanism(rod := jo.RigidBody("rod", 1.0, (0.01, 0.1, 0.1)),
        hinge := jo.Revolute("hinge", jo.ground["origin"], rod["origin"]),
        jo.Spring("spring", hinge.angle, 10.0, free=0.0)))  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.modes(still)
        jo.simulate(still, 1e-3)
    free = jo.compile(jo.Mechanism(rod, hinge))
    with pytest.warns(jo.JoustoWarning, match="no initial velocity: nothing will move"):
        jo.simulate(free, 1e-3)
