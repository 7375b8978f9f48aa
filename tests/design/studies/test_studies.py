"""Studies: closed forms, what is done again, failures, ways to work, kills."""

from __future__ import annotations

import functools
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from design.studies import machines
from design.studies.machines import CANTILEVER, FORCES, RUN
from jousto.design.studies.running.journal import Journal
from jousto.schema.file.document import read_document
from jousto.schema.read import build_model, parse_model
from jousto.schema.variants import Variants

TESTS = Path(__file__).parents[2]


def forces(**how: Any) -> jo.design.Study:
    return jo.study(machines.pushed, FORCES, {"way": machines.way, **how.pop("more", {})}, **RUN)


# -- closed forms -------------------------------------------------------------------------------


def test_the_period_of_a_pendulum_follows_its_length() -> None:
    """T = 2 pi sqrt(l / g) within the amplitude's 1e-6 / 16."""
    length = jo.Parameter("length", 1.0, bounds=(0.2, 4.0), unit="m")
    study = jo.study(machines.bob, length, ["frequency(1, rest)", "mass"], {"length": 7})
    table = study.table
    assert table is not None and len(table) == 7 and table.good.all()
    expected = np.sqrt(9.81 / table["length"]) / (2 * np.pi)
    # the point mass has 1e-9 kg m2 of its own
    np.testing.assert_allclose(table["frequency(1, rest)"], expected, rtol=1e-6)
    assert (table["mass"] == 1.0).all()
    assert study.counts["runs"] == 0  # nothing asked for one
    assert study.units == ("Hz", "kg")


def test_the_frequency_of_a_cantilever_follows_its_height() -> None:
    """Bending about the axis that the height stiffens: f ~ h (Euler-Bernoulli: slender)."""

    def beam(height: float) -> jo.Mechanism:
        section = jo.Rectangle(0.05, height)
        part = jo.Part.beam(length=2.0, section=section, material=jo.material("S355"), elements=10)
        arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(["start"], 6)))
        return jo.Mechanism(arm, jo.Fixed("clamp", jo.ground["origin"], arm["start"]))

    height = jo.Parameter("height", 0.02, bounds=(0.01, 0.04), unit="m")
    study = jo.study(beam, height, ["frequency(1)", "mass(arm)"])
    x = np.array([[0.01], [0.02], [0.04]])
    y = study(x)
    steel = jo.material("S355")
    radius = x[:, 0] / np.sqrt(12.0)
    expected = 1.87510407**2 / (2 * np.pi * 4.0) * radius * np.sqrt(steel.E / steel.rho)
    # shear and rotary inertia take off some (h / l)^2, the mesh adds less than that
    np.testing.assert_allclose(y[:, 0], expected, rtol=2e-3)
    np.testing.assert_allclose(y[:, 1], steel.rho * 0.05 * x[:, 0] * 2.0, rtol=1e-12)
    assert study.counts["reductions"] == 3


def test_inputs_of_a_model_are_parameters() -> None:
    study = forces()
    x = np.array([[2.0, 4.0], [2.0, 2.0], [4.0, 4.0]])
    np.testing.assert_allclose(study(x)[:, 0], x[:, 1] / x[:, 0] / 2, rtol=1e-12)
    assert study(x[0]).shape == (1,)
    model = jo.compile(machines.pushed(2.0))
    alone = jo.study(model, FORCES[1], "last(way)", **RUN)
    assert alone([[8.0]])[0, 0] == pytest.approx(2.0, rel=1e-12)


def test_runs_are_those_of_simulate() -> None:
    study = forces(more={"peak": "peak(way)"})
    run = jo.simulate(
        jo.compile(machines.pushed(3.0)), 1.0, solver=jo.RK4(0.1), inputs={"force": 5}
    )
    again = study.case([3.0, 5.0]).run
    for name in ("q", "v", "time"):
        assert (getattr(run, name) == getattr(again, name)).all()
    assert (run["way"] == again["way"]).all()
    assert run.attributes.keys() == again.attributes.keys()


def test_runs_of_a_fixed_step_go_through_the_engine_in_one_call(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from jousto.simulation.running import repeated_runs

    def never(*given: object, **how: object) -> None:
        raise AssertionError

    study = forces()
    monkeypatch.setattr(repeated_runs, "simulate", never)
    np.testing.assert_allclose(study(X)[:, 0], WAY, rtol=1e-12)


def test_a_run_knows_nothing_of_the_one_before() -> None:
    """Friction that sticks, an event and energies remember: a study's engine forgets them."""
    block = jo.RigidBody("block", 1.0, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            block,
            slide,
            jo.JointForce("push", slide.displacement, jo.Input("force")),
            jo.Friction("rub", slide, 0.2, 0.3, law=jo.mechanism.StickSlip()),
            jo.mechanism.Event("far", slide.displacement, threshold=0.1),
            jo.Gravity((0, -10.0, 0)),
            jo.CoordinateSensor("way", slide.displacement),
        )
    )
    runs: list[jo.Solution] = []

    def kept(run: jo.Solution) -> int:
        runs.append(run)
        return len(runs)

    forces = (2.9, 8.0, 2.9, 8.0)
    jo.study(model, jo.Parameter("force", 0.0), kept, **RUN)([[force] for force in forces])
    for run, force in zip(runs, forces, strict=True):
        alone = jo.simulate(model, inputs={"force": force}, **RUN)
        assert (run["way"] == alone["way"]).all()
        assert (run.energy.work == alone.energy.work).all()
        assert run.events == alone.events
        assert len(run.events) == (force > 3.0)  # what static friction holds never comes far


def test_warnings_of_threads_are_counted() -> None:
    """RK4 loses energy where a step is 1.5 rad of a swing: each run warns of it."""

    def swing(rate: float) -> jo.Mechanism:
        block = jo.RigidBody("block", 1.0, (1, 1, 1), velocity=(1, 0, 0))
        slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
        spring = jo.Spring("spring", slide.displacement, stiffness=rate)
        return jo.Mechanism(block, slide, spring, jo.CoordinateSensor("way", slide.displacement))

    study = jo.study(swing, jo.Parameter("rate", 225.0), "last(way)", **RUN)
    table = study.run([[225.0 + k] for k in range(6)], workers=2)
    assert table.good.all()
    assert sum(table.notes.values()) == 6
    assert all("energy balance" in note for note in table.notes)


# -- what is done again -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "values", "reductions", "compilations"),
    [
        # the nominal machine first: two reductions, one compilation
        ("height", (0.02, 0.025, 0.03), 4, 3),
        # numbers of springs and forces are written into the compiled model
        ("k", (1e3, 2e3, 3e3), 2, 1),
        ("load", (10.0, 20.0, 30.0), 2, 1),
    ],
)
def test_only_what_changed_is_done_again(
    name: str, values: tuple[float, ...], reductions: int, compilations: int
) -> None:
    file = parse_model(CANTILEVER)
    study = jo.study(file, name, ["last(tip.z)", "mass"])
    before = dict(study.counts)
    assert (before["reductions"], before["runs"]) == (2, 0)
    y = study(np.array(values)[:, None])
    assert np.isfinite(y).all() and np.ptp(y) > 0
    found = study.counts
    assert (found["reductions"], found["compilations"], found["runs"]) == (
        *(reductions, compilations),
        3,
    )
    # all of it again: only runs
    study(np.array(values)[:, None])
    assert study.counts == found | {"runs": 6}


def test_an_input_only_runs_again() -> None:
    study = forces()
    study(np.array([[2.0, f] for f in np.linspace(1, 9, 20)]))
    assert study.counts == {"reductions": 0, "compilations": 1, "runs": 20}


def test_a_function_reduces_equal_parts_once() -> None:
    def beam(height: float, k: float) -> jo.Mechanism:
        part = jo.Part.beam(
            length=1.0,
            section=jo.Rectangle(0.01, height),
            material=jo.material("S355"),
            elements=4,
        )
        arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(["start"], 2)))
        hold = jo.Fixed("hold", jo.ground["origin"], arm["start"])
        return jo.Mechanism(arm, hold, jo.Force("pull", arm["end"], (k, 0, 0)))

    p = (jo.Parameter("height", 0.02, unit="m"), jo.Parameter("k", 10.0, unit="N/m"))
    study = jo.study(beam, p, "mass")
    study([[0.02, 10.0], [0.02, 20.0], [0.03, 20.0], [0.02, 30.0]])
    assert study.counts == {"reductions": 2, "compilations": 3, "runs": 0}


# -- failures and mistakes ----------------------------------------------------------------------


def test_failed_points_are_kept_with_their_reason(tmp_path: Path) -> None:
    mass = jo.Parameter("mass", 2.0, unit="kg", bounds=(-1.0, 8.0))
    x = np.array([[2.0, 4.0], [-1.0, 4.0], [9.0, 4.0], [4.0, 4.0], [np.nan, 1.0]])
    study = jo.study(machines.pushed, (mass, FORCES[1]), "last(way)", **RUN)
    table = study.run(x, path=tmp_path / "table.h5")
    assert table.good.tolist() == [True, False, False, True, False]
    assert "body 'block': mass is -1 kg, must be a positive number" in table.reasons[1]
    assert table.reasons[2] == "mass is 9, outside of -1 to 8"
    assert np.isnan(table["last(way)"][[1, 2, 4]]).all()
    assert "failed 1 x: mass is 9" in str(table)
    assert not (tmp_path / "table.h5.jsonl").exists()
    again = jo.design.read_study(tmp_path / "table.h5")
    assert again.reasons == table.reasons and again.units == table.units
    np.testing.assert_array_equal(again.x, table.x)
    np.testing.assert_array_equal(again.y, table.y)


def test_all_mistakes_are_told_at_once() -> None:
    with pytest.raises(jo.InputError) as error:
        jo.study(
            *(parse_model(CANTILEVER), ["hight", "k"], ["max(tup.y)", "maxx(tip.y)", "mass"]),
            t_end=-1.0,
        )
    assert "study: t_end is -1 s, must be a positive number" in str(error.value)
    assert "no parameter 'hight'; did you mean 'height'?" in str(error.value)
    assert "no outcome 'maxx'; did you mean 'max'?" in str(error.value)
    wrong = ["max(tup.y)", "max(tip)", "max(tip.w)", "stress(arn)", "reaction(hold)", "damage(arm)"]
    with pytest.raises(jo.InputError) as error:
        jo.study(parse_model(CANTILEVER), "k", wrong)
    text = str(error.value)
    assert len(error.value.problems) == len(wrong)
    for part in (
        "no sensor 'tup.y'",
        "several components; name one: tip.x, tip.y, tip.z",
        "no component 'w'",
        "no body 'arn' whose stress is known; did you mean 'arm'?",
        "nothing measures joint 'hold'; add a sensor of type reaction",
        "the model file has no fatigue",
    ):
        assert part in text
    with pytest.raises(jo.InputError, match="parameter 'x': is unused"):
        jo.study(machines.pushed, (*FORCES, jo.Parameter("x", 1.0)), "m = mass")
    with pytest.raises(jo.InputError, match="no outcomes; an outcome is mass"):
        jo.study(machines.pushed, FORCES)
    with pytest.raises(jo.InputError, match=r"must be \(n, 2\): mass, force"):
        forces()([[1.0]])
    with pytest.raises(jo.InputError, match="how is 'thread'; did you mean 'threads'"):
        forces().run([[1.0, 1.0]], how="thread")
    with pytest.raises(jo.InputError, match="workers is 0"):
        forces().run([[1.0, 1.0]], workers=0)


def test_stress_and_reaction_are_outcomes() -> None:
    study = jo.study(
        parse_model(CANTILEVER), "load", ["stress(side)", "reaction(clamp)", "rms(tip.z)"]
    )
    y = study([[10.0], [20.0]])
    assert study.units == ("Pa", "N", "m")
    # small motions: everything in proportion to the load
    np.testing.assert_allclose(y[1, 0] / y[0, 0], 2.0, rtol=1e-3)
    run = study.case([20.0]).run
    spots = jo.hot_spots(run, bodies="side", count=1).spots
    assert y[1, 0] == spots[0].value
    assert y[1, 1] == np.linalg.norm(run["root"][:, :3], axis=1).max()


# -- ways to work, files, kills -----------------------------------------------------------------

X = np.array([[2.0, f] for f in np.linspace(0.5, 7.0, 14)])
WAY = X[:, 1] / 4.0


@pytest.mark.parametrize(("workers", "how"), [(1, "threads"), (2, "threads"), (2, "processes")])
def test_all_ways_give_the_same(workers: int, how: str, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    study = forces()
    table = study.run(
        X,
        workers=workers,
        how=how,
        path=tmp_path / "t.csv",
        progress=lambda done, total: seen.append((done, total)),
    )
    np.testing.assert_allclose(table["way"], WAY, rtol=1e-12)
    assert seen == [(k, len(X)) for k in range(len(X) + 1)]
    assert study.counts["runs"] == len(X)
    rows = (tmp_path / "t.csv").read_text().splitlines()
    assert rows[0] == "mass (kg),force (N),way,failed" and len(rows) == len(X) + 1
    # everything is there: nothing is done again
    again = forces()
    np.testing.assert_array_equal(again.run(X, path=tmp_path / "t.csv").y, table.y)
    assert again.counts["runs"] == 0


@pytest.mark.parametrize("how", ["processes", "dask"])
def test_a_process_that_dies_loses_nothing(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if how == "dask":
        pytest.importorskip("distributed")
    monkeypatch.setenv("JOUSTO_TEST_MARK", str(tmp_path / "mark"))
    study = jo.study(machines.pushed, FORCES, {"way": machines.deadly}, **RUN)
    x = np.vstack([X, [[2.0, 8.0]]])
    table = study.run(x, workers=2, how=how, path=tmp_path / "t.h5")
    assert (tmp_path / "mark").exists()
    np.testing.assert_allclose(table["way"], x[:, 1] / 4.0, rtol=1e-12)


@pytest.mark.usefixtures("broken_pipe")
def test_a_point_that_kills_every_process_fails_alone(tmp_path: Path) -> None:
    study = jo.study(machines.pushed, FORCES, {"way": machines.fatal}, **RUN)
    table = study.run([[2.0, 1.0], [2.0, 8.0], [2.0, 2.0]], workers=1, how="processes")
    assert table.reasons == ("", "its process died", "")
    np.testing.assert_allclose(table["way"][[0, 2]], [0.25, 0.5], rtol=1e-12)


@pytest.mark.parametrize(("workers", "how"), [(1, "threads"), (2, "processes")])
def test_a_killed_study_goes_on(workers: int, how: str, tmp_path: Path) -> None:
    """kill -9 of the program; what it computed is not computed again."""
    mark, path = tmp_path / "mark", tmp_path / "t.h5"
    code = (
        "import numpy as np\nimport jousto as jo\nfrom design.studies import machines\n"
        "if __name__ == '__main__':\n"
        "    m = machines\n"
        "    s = jo.study(m.pushed, m.FORCES, {'way': m.slow}, **m.RUN)\n"
        "    x = [[2.0, f] for f in np.linspace(0.5, 7.0, 400)]\n"
        f"    s.run(x, workers={workers}, how={how!r}, path={str(path)!r})\n"
    )
    script = tmp_path / "script.py"
    script.write_text(code)
    env = os.environ | {"JOUSTO_TEST_MARK": str(mark), "PYTHONPATH": str(TESTS)}
    program = subprocess.Popen([sys.executable, str(script)], env=env, start_new_session=True)
    lines = path.with_name("t.h5.jsonl")
    try:
        while program.poll() is None and (not mark.exists() or mark.stat().st_size < 6):
            time.sleep(0.02)
        assert program.poll() is None
    finally:
        os.killpg(program.pid, signal.SIGKILL)
        program.wait()
    computed = mark.stat().st_size
    study = jo.study(machines.pushed, FORCES, {"way": machines.slow}, **RUN)
    journal = Journal(lines, study._about())
    # of each worker the last one may have been marked and not written
    assert computed - workers <= len(journal.rows) <= computed
    assert len(journal.rows) >= 4
    known = np.array(list(journal.rows))
    os.environ["JOUSTO_TEST_MARK"] = str(tmp_path / "second")
    try:
        table = study.run(known, path=path)
    finally:
        del os.environ["JOUSTO_TEST_MARK"]
    assert study.counts["runs"] == 0 and not (tmp_path / "second").exists()
    np.testing.assert_allclose(table["way"], known[:, 1] / 4.0, rtol=1e-12)


def test_a_line_that_a_kill_cut_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "t.jsonl"
    forces().run(X, path=path)
    whole = path.read_bytes()
    path.write_bytes(whole[:-10])
    study = forces()
    np.testing.assert_allclose(study.run(X, path=path)["way"], WAY, rtol=1e-12)
    assert study.counts["runs"] == 1
    assert path.read_bytes() == whole


def test_a_file_of_another_study_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.h5"
    forces().run(X, path=path)
    other = jo.study(machines.pushed, FORCES, "peak(way)", **RUN)
    with pytest.raises(jo.InputError, match="contains another study"):
        other.run(X, path=path)
    lines = tmp_path / "u.jsonl"
    forces().run(X, path=lines)
    with pytest.raises(jo.InputError, match="contains another study .outcomes differ"):
        other.run(X, path=lines)
    lines.write_text("hello\n")
    with pytest.raises(jo.InputError, match="is not the journal of a study"):
        other.run(X, path=lines)
    with pytest.raises(jo.InputError, match="'.txt' is not a format of tables"):
        other.run(X, path=tmp_path / "t.txt")


class Maker:
    def __init__(self, mass: Any) -> None:
        self.mass = mass

    def __call__(self, more: float) -> jo.Mechanism:
        return machines.pushed(self.mass + more)


def plus(mass: float, more: float) -> jo.Mechanism:
    return machines.pushed(mass + more)


@pytest.mark.parametrize("name", ["t.h5", "t.jsonl"])
@pytest.mark.parametrize(
    ("make", "place"),
    [
        (lambda m: lambda more: machines.pushed(m + more), "model"),
        (lambda m: functools.partial(plus, m), "model"),
        (Maker, "model"),
        (lambda m: Maker(m).__call__, "model"),
        (machines.pushed, "model"),
        (lambda m: jo.compile(machines.pushed(m)), "model"),
        (lambda m: lambda run: m * run["way"][-1, 0], "outcomes"),
        (lambda m: jo.design.Function("y", lambda run, m=m: m), "outcomes"),
        (lambda m: lambda model: replace(jo.simulate(model, m).state(), time=0.0), "run"),
    ],
)
def test_what_functions_hold_makes_another_study(
    make: Any, place: str, name: str, tmp_path: Path
) -> None:
    def study(m: float) -> jo.design.Study:
        given: dict[str, Any] = {"model": lambda more: machines.pushed(more)}
        given |= {"outcomes": "last(way)"} | {place: make(m)}
        more = jo.Parameter("more", 1.0, unit="kg")
        still = isinstance(given["model"], jo.Mechanism | jo.Model)
        p = FORCES[1] if still else (more, FORCES[1])
        state = {"state": given["run"]} if place == "run" else {}
        return jo.study(given["model"], p, {"y": given["outcomes"]}, **RUN, **state)

    x = [[3.0]] if len(study(1.0).parameters) == 1 else [[1.0, 3.0]]
    first = study(1.0).run(x, path=tmp_path / name)
    same = study(1.0)
    assert same.run(x, path=tmp_path / name).y == first.y and same.counts["runs"] == 0
    with pytest.raises(jo.InputError, match=f"contains another study .{place} differ"):
        study(5.0).run(x, path=tmp_path / name)


def test_what_cannot_be_compared_is_not_gone_on_with(tmp_path: Path) -> None:
    def study() -> jo.design.Study:
        lock = threading.Lock()

        def last(run: jo.Solution) -> Any:
            with lock:
                return run["way"][-1, 0]

        return forces(more={"last": last})

    first, path = study(), tmp_path / "t.h5"
    y = first.run(X, path=path).y
    np.testing.assert_array_equal(first.run(X, path=path).y, y)
    with pytest.raises(jo.InputError, match="a lock in its outcomes cannot be compared; name"):
        study().run(X, path=path)
    np.testing.assert_array_equal(study().run(X, path=tmp_path / "u.h5").y, y)


def test_files_that_a_model_names_belong_to_it(tmp_path: Path) -> None:
    table, model = tmp_path / "push.csv", tmp_path / "model.yaml"
    model.write_text("{a: [push.csv], b: part.yaml}")
    (tmp_path / "part.yaml").write_text("{mesh: {file: mesh.inp}}")
    (tmp_path / "mesh.inp").write_text("1")
    table.write_text("0,1")

    def key() -> str:
        return Variants(build_model, read_document(model), ()).key

    keys = [key(), key()]
    assert keys[0] == keys[1]
    table.write_text("0,2")
    keys.append(key())
    (tmp_path / "mesh.inp").write_text("2")
    assert len({*keys, key()}) == 3


def test_a_start_from_rest_is_the_same_in_another_process(tmp_path: Path) -> None:
    code = (
        "import jousto as jo\nfrom design.studies import machines as m\n"
        "s = jo.study(m.pushed, m.FORCES, {'way': m.way}, state=jo.equilibrium, **m.RUN)\n"
        "print(sorted(s._about()['run'].items()), s._about()['outcomes'], s._about()['model'])\n"
    )
    env = os.environ | {"PYTHONPATH": str(TESTS)}
    run = [sys.executable, "-c", code]
    found = [
        subprocess.run(run, env=env | {"PYTHONHASHSEED": seed}, capture_output=True, check=True)
        for seed in "12"
    ]
    assert found[0].stdout == found[1].stdout != b""
    assert b"cannot be compared" not in found[0].stdout


@pytest.mark.parametrize(("workers", "how"), [(1, "threads"), (2, "threads"), (2, "processes")])
def test_a_sample_that_is_no_number_fails_alone(workers: int, how: str) -> None:
    table = forces().run([[2.0, 1.0], [2.0, np.nan], [2.0, 2.0]], workers=workers, how=how)
    assert table.reasons == ("", "force is nan, must be finite", "")
    np.testing.assert_allclose(table["way"][[0, 2]], [0.25, 0.5], rtol=1e-12)


def test_more_points_go_on_from_a_finished_table(tmp_path: Path) -> None:
    path = tmp_path / "t.h5"
    forces().run(X[:5], path=path)
    study = forces()
    assert len(study.run(X, path=path)) == len(X)
    assert study.counts["runs"] == len(X) - 5


def test_a_table_becomes_a_frame(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    table = forces().run(X)
    frame = table.to_pandas()
    assert list(frame) == ["mass", "force", "way", "failed"]
    assert frame.attrs["units"]["mass"] == "kg"
    np.testing.assert_array_equal(frame["way"], table["way"])
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        with pytest.raises(jo.InputError, match="needs the package pyarrow"):
            table.save(tmp_path / "t.parquet")
    else:
        table.save(tmp_path / "t.parquet")
        assert pandas.read_parquet(tmp_path / "t.parquet")["way"].tolist() == table["way"].tolist()


def test_what_cannot_travel_is_refused() -> None:
    lock = threading.Lock()

    def guarded(mass: float) -> jo.Mechanism:
        with lock:
            return machines.pushed(mass)

    study = jo.study(guarded, FORCES, "last(way)", **RUN)
    with pytest.raises(jo.InputError, match="cannot be sent to another process"):
        study.run(X, workers=2, how="processes")


def test_dask_works_on_this_machine(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    study = forces()
    table = study.run(X, workers=2, how="dask", path=tmp_path / "t.h5")
    np.testing.assert_allclose(table["way"], WAY, rtol=1e-12)
    assert study.counts["runs"] == len(X)
    with distributed.Client(
        processes=False, n_workers=1, dashboard_address="127.0.0.1:0"
    ) as client:
        np.testing.assert_allclose(forces().run(X, workers=client)["way"], WAY, rtol=1e-12)


@pytest.mark.slow
def test_a_killed_scheduler_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """kill -9 of a scheduler of its own: the study ends, and goes on without what it did."""
    distributed = pytest.importorskip("distributed")
    file, path = tmp_path / "scheduler.json", tmp_path / "t.h5"
    monkeypatch.setenv("JOUSTO_TEST_MARK", str(tmp_path / "mark"))
    env = os.environ | {"PYTHONPATH": str(TESTS)}
    own = ["--scheduler-file", str(file), "--no-dashboard"]
    address = [*own, "--host", "127.0.0.1", "--port", "0"]
    worker = [*own, "--no-nanny", "--nthreads", "1", "--death-timeout", "30"]
    programs = [
        subprocess.Popen([sys.executable, "-m", f"distributed.cli.dask_{name}", *given], env=env)
        for name, given in (("scheduler", address), ("worker", worker))
    ]

    def kill(done: int, total: int) -> None:
        if done == 6:
            programs[0].kill()

    x = np.array([[2.0, f] for f in np.linspace(0.5, 7.0, 40)])
    study = jo.study(machines.pushed, FORCES, {"way": machines.slow}, **RUN)
    try:
        for _ in range(600):
            if file.exists():
                break
            time.sleep(0.05)
        with distributed.Client(scheduler_file=str(file), timeout=60) as client:
            client.wait_for_workers(1, timeout=120)
            with pytest.raises(jo.InputError, match=r"cluster is gone.* same path goes on"):
                study.run(x, workers=client, path=path, progress=kill)
    finally:
        for program in programs:
            program.kill()
            program.wait()
    done = len(Journal(path.with_name("t.h5.jsonl"), study._about()).rows)
    assert 6 <= done < len(x) and not path.exists()
    runs = study.counts["runs"]  # of chunks that came back
    np.testing.assert_allclose(study.run(x, path=path)["way"], x[:, 1] / 4.0, rtol=1e-12)
    assert study.counts["runs"] - runs == len(x) - done


# -- samples ------------------------------------------------------------------------------------


def test_samples_fill_bounds_and_follow_distributions() -> None:
    p = (
        jo.Parameter("a", 1.0, bounds=(0.0, 4.0)),
        jo.Parameter("b", 5.0, distribution="normal(mean=5, sd=2)"),
    )
    hypercube = jo.design.latin_hypercube(p, 100)
    # one in each stratum
    assert sorted((hypercube[:, 0] * 25).astype(int)) == list(range(100))
    ranks = p[1].distribution.cdf(hypercube[:, 1]) * 100
    assert sorted(ranks.astype(int)) == list(range(100))
    for sample in (jo.design.sobol, jo.design.random_samples):
        x = sample(p, 256)
        assert x.shape == (256, 2) and (x[:, 0] >= 0).all() and (x[:, 0] <= 4).all()
        assert (x == sample(p, 256)).all() and (x != sample(p, 256, seed=1)).any()
        # five deviations of the mean of independent points
        assert abs(x[:, 1].mean() - 5.0) < 5 * 2.0 / 16
    with pytest.raises(jo.InputError, match="has neither bounds nor a distribution"):
        jo.design.sobol([jo.Parameter("c", 1.0)], 4)


def test_a_grid_has_all_combinations() -> None:
    p = (jo.Parameter("a", 1.0, bounds=(0.0, 4.0)), jo.Parameter("b", 5.0))
    assert jo.design.grid(p, {"a": 3, "b": [1, 2]}).tolist() == [
        [a, b] for a in (0.0, 2.0, 4.0) for b in (1.0, 2.0)
    ]
    assert jo.design.grid(p, {"a": 2}).tolist() == [[0.0, 5.0], [4.0, 5.0]]
    with pytest.raises(jo.InputError, match="has no bounds for a grid"):
        jo.design.grid(p, 3)
    with pytest.raises(jo.InputError, match="no parameter 'c'"):
        jo.design.grid(p, {"c": 3})


def test_samples_come_from_a_table(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("force (kN),mass\n0.004,2\n2 N,4 kg\n")
    assert jo.design.read_samples(path, FORCES).tolist() == [[2.0, 4.0], [4.0, 2.0]]
    path.write_text("forc,mass\n1,2 m\n1,x\n")
    with pytest.raises(jo.InputError) as error:
        jo.design.read_samples(path, FORCES)
    assert [str(p) for p in error.value.problems] == [
        f"{path}:1: no parameter 'forc'; did you mean 'force'?",
        f"{path}:2: mass: is 2 m (a length), must be in kg",
        f"{path}:3: mass: expects a number or a quantity such as 4 mm, got 'x'",
    ]
