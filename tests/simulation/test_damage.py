"""Damaged and hostile results files: one sentence, nothing foreign read, no internal error."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from jousto.base import checksums

STEEL = jo.Material(E=2.07e11, nu=0.3, rho=7850)
FOREIGN = np.array([17.0, 4.0])  # what nobody may read


@pytest.fixture(scope="module")
def original(tmp_path_factory, rod):
    """A run with modes, stress, a beam, an input, an event and friction that sticks."""
    arm = jo.FlexibleBody("arm", rod, modal_velocities=np.full(rod.n, 1e-3))
    pivot = jo.Revolute("pivot", jo.ground["origin"], arm["start"], (0, 0, 1))
    rub = jo.Friction("rub", pivot, 0.1, radius=0.01, preload=1.0, law=jo.mechanism.StickSlip())
    rope = jo.BeamBody("rope", [(0, 0, 0), (0, 1, 0)], jo.Rectangle(0.02, 0.02), STEEL, elements=2)
    wall = jo.Fixed("wall", jo.ground["origin"], rope["start"])
    push = jo.Force("push", rope["end"], (0, 1, 0), signal=jo.Input("u", 1.0))
    angle = jo.CoordinateSensor("angle", jo.Angle(jo.ground["origin"], arm["start"]))
    hinge = jo.ReactionSensor("hinge", pivot)
    event = jo.mechanism.Event("low", angle, threshold=-1e-3)
    gravity = jo.Gravity((0, -9.81, 0))
    items = (arm, pivot, rub, rope, wall, push, angle, hinge, event, gravity)
    path = tmp_path_factory.mktemp("damage") / "run.h5"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        model = jo.compile(jo.Mechanism(*items, name="small"))
        jo.simulate(model, 0.03, output_step=0.01, path=path, model_text="name: small\n")
    return path


def everything(path: Path) -> list[np.ndarray]:
    """Read all that a results file gives."""
    run = jo.load(path)
    found = [run.time, run.q, run.v, run.multipliers, *(run[name] for name in run)]
    found += [*vars(run.energy).values(), *vars(run.residuals).values(), *vars(run.work).values()]
    for body in run.bodies:
        found += [body.nodes, body.elements, body.modes, run.coordinates(body.name)]
        stress = run.stress_modes(body.name)
        found += [] if stress is None else [stress.positions, stress.axes, stress.modes]
    for beam in run.beams:
        found += [beam.nodes, beam.data, *run.beam_states(beam.name)]
    state = run.state()
    found += [state.q, state.v, state.lam]
    facts = [str(run.about(name)) for name in run] + [str(run.events), repr(run), run.model_text]
    facts += [run.name, str(run.complete), str(run.stressed), run.energy.verdict]
    return [*found, np.array([" ".join(facts)])]


def outcome(path: Path) -> str | list[np.ndarray]:
    """Return what a file gives, or the sentence that refuses it; anything else is a failure."""
    try:
        return everything(path)
    except jo.InputError as error:
        text = str(error)
    assert str(path) in text
    assert "\n" not in text
    return text


# -- accidents -------------------------------------------------------------------------------------


def test_a_changed_byte_is_found_or_does_not_matter(original, tmp_path):
    """Wherever a bit tips: the results are refused, or are those that were written."""
    whole, right = original.read_bytes(), everything(original)
    rng = np.random.default_rng(3)
    used = np.flatnonzero(np.frombuffer(whole, np.uint8))
    refused = 0
    for at in [*rng.choice(used, 40), *rng.integers(0, len(whole), 10)]:
        damaged = bytearray(whole)
        damaged[at] ^= 1 << rng.integers(8)
        path = tmp_path / "run.h5"
        path.write_bytes(damaged)
        found = outcome(path)
        if isinstance(found, str):
            refused += 1
        else:
            for one, other in zip(found, right, strict=True):
                np.testing.assert_array_equal(one, other, err_msg=f"byte {at}")
    assert refused > 35


def test_a_file_cut_short_is_refused(original, tmp_path):
    whole = original.read_bytes()
    rng = np.random.default_rng(4)
    for size in [0, 1, 8, 100, *rng.integers(0, len(whole) // 2, 20)]:
        path = tmp_path / "run.h5"
        path.write_bytes(whole[:size])
        assert isinstance(outcome(path), str), size


def test_changed_numbers_are_named(original, tmp_path):
    path = tmp_path / "run.h5"
    shutil.copy(original, path)
    with h5py.File(path) as file:
        at = file["state/v"].id.get_offset() + 8
    with path.open("r+b") as file:
        file.seek(at)
        file.write(np.array(1e-3).tobytes())
    run = jo.load(path)
    assert run.q.shape[0] == 4  # the rest is good
    with pytest.raises(jo.InputError, match="state/v was changed between rows 0 and 3"):
        run.v  # noqa: B018


def test_checksums_reach_over_many_blocks(pendulum, tmp_path, monkeypatch):
    monkeypatch.setattr(checksums, "BLOCK", 4)
    run = jo.simulate(pendulum, 0.01, path=tmp_path / "run.h5")
    whole = run["tip"]
    with h5py.File(run.path) as file:
        at = file["sensors/tip"].id.get_offset() + 5 * 24  # row 5
    with run.path.open("r+b") as file:
        file.seek(at)
        file.write(b"\1")
    again = jo.load(run.path)
    with pytest.raises(jo.InputError, match="sensors/tip was changed between rows 4 and 7"):
        again["tip"]
    np.testing.assert_array_equal(again._records.read("sensors/tip", slice(8, 10)), whole[8:10])


# -- other programs and bad will -------------------------------------------------------------------


def places(path: Path) -> tuple[list[str], list[tuple[str, str]]]:
    """Return all objects and all attributes of a file."""
    items: list[str] = []
    with h5py.File(path) as file:
        file.visit(items.append)
        attrs = [(place, name) for place in ["/", *items] for name in file[place].attrs]
    return items, attrs


def edits(path: Path, rng: np.random.Generator):
    """Yield words and functions that change an open file."""
    items, attrs = places(path)

    def replaced(place, make):
        def change(file):
            old = file[place]
            data = old[()] if isinstance(old, h5py.Dataset) else np.zeros(3)
            about = dict(old.attrs)
            del file[place]
            make(file, place, data)
            if place in file and isinstance(file.get(place, getlink=True), h5py.HardLink):
                file[place].attrs.update(about)

        return change

    def fill(file, place, data):
        bad = np.full(data.shape, np.nan) if data.dtype.kind == "f" else data
        file[place] = np.full(data.shape, -7) if data.dtype.kind in "iu" else bad

    def huge(file, place, data):
        file.create_dataset(place, (10**7, 10**6), "f8", chunks=(10, 10))

    def claims(file, place, data):
        plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plist.set_alloc_time(h5py.h5d.ALLOC_TIME_LATE)
        space = h5py.h5s.create_simple((10**7, 10**6))
        h5py.h5d.create(file.id, place.encode(), h5py.h5t.IEEE_F64LE, space, plist)

    makers = {
        "gone": lambda file, place, data: None,
        "a group": lambda file, place, data: file.create_group(place),
        "text": lambda file, place, data: file.create_dataset(place, data="text"),
        "whole numbers": lambda file, place, data: file.create_dataset(place, data=np.arange(5)),
        "scalar": lambda file, place, data: file.create_dataset(place, data=1.5),
        "one more axis": lambda f, place, data: f.create_dataset(place, data=np.array([data])),
        "shorter": lambda f, place, d: f.create_dataset(place, data=d[:1] if np.ndim(d) else d),
        "nan": fill,
        "huge": huge,
        "large claim": claims,
        "a soft link": lambda f, place, d: f.__setitem__(place, h5py.SoftLink("/time")),
    }
    for place in items:
        for word in rng.choice(list(makers), 1):
            yield f"{place} {word}", replaced(place, makers[word])
    for place, name in attrs:
        if rng.integers(3) == 0:
            continue
        if rng.integers(2):
            yield f"{place}@{name} gone", lambda f, p=place, n=name: f[p].attrs.__delitem__(n)
        else:
            value = [3.5, np.arange(4.0), "words", np.nan][rng.integers(4)]
            yield (
                f"{place}@{name} other",
                lambda f, p=place, n=name, v=value: f[p].attrs.__setitem__(n, v),
            )


def test_edited_files_are_refused_or_read(original, tmp_path):
    """Many changes by another program, which removes the checksums."""
    rng = np.random.default_rng(5)
    path = tmp_path / "run.h5"
    refused = count = 0
    for word, change in edits(original, rng):
        if rng.integers(4) == 0:
            continue
        shutil.copy(original, path)
        with h5py.File(path, "r+") as file:
            change(file)
        try:
            refused += isinstance(outcome(path), str)
        except Exception as error:
            raise AssertionError(f"{word}: {type(error).__name__}: {error}") from error
        count += 1
    assert count > 90
    assert refused > 0.5 * count  # units, descriptions and joints do not matter


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda f: f.__delitem__("diagnostics/step"), "diagnostics/step is missing"),
        (lambda f: f["bodies/arm"].attrs.__delitem__("modes"), "attribute modes is missing"),
        (lambda f: f["time"].__setitem__(1, np.nan), "time must be finite and ascending"),
        (lambda f: f["rows"].__setitem__((), 99), "rows is 99, the datasets have 4 rows"),
        (lambda f: f["bodies/arm/nodes"].__setitem__((0, 0), np.inf), "arm/nodes contains numbers"),
    ],
)
def test_the_field_is_named(original, tmp_path, change, sentence):
    path = tmp_path / "run.h5"
    shutil.copy(original, path)
    with h5py.File(path, "r+") as file:
        change(file)
    assert sentence in str(outcome(path))
    assert "run the model again" in str(outcome(path))


def steal(kind: str, path: Path, secret: Path) -> None:
    """Make the sensor of a file show the content of another file."""
    with h5py.File(path, "r+") as file:
        about = dict(file["sensors/angle"].attrs)
        shape = file["sensors/angle"].shape
        del file["sensors/angle"]
        if kind == "external link":
            file["sensors/angle"] = h5py.ExternalLink(secret, "/secret")
        elif kind == "external storage":
            file.create_dataset("sensors/angle", shape, "f8", external=[(str(secret), 0, 32)])
        elif kind == "virtual":
            layout = h5py.VirtualLayout(shape, "f8")
            layout[:] = h5py.VirtualSource(str(secret), "secret", shape)
            file.create_virtual_dataset("sensors/angle", layout)
        elif kind == "group of another file":
            del file["sensors"]
            file["sensors"] = h5py.ExternalLink(secret, "/")
        if kind not in ("external link", "group of another file"):
            file["sensors/angle"].attrs.update(about)


@pytest.mark.parametrize(
    "kind", ["external link", "external storage", "virtual", "group of another file"]
)
def test_no_foreign_file_is_read(kind, original, tmp_path):
    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["secret"] = np.full((4, 1), 1234.5)
        file["angle"] = np.full((4, 1), 1234.5)
    path = tmp_path / "run.h5"
    shutil.copy(original, path)
    steal(kind, path, secret)
    found = outcome(path)
    assert isinstance(found, str)
    assert "another" in found
    code, text = call("export", path, "-o", tmp_path / "a.csv")
    assert code == 2
    assert "internal error" not in text
    assert not (tmp_path / "a.csv").exists()


def test_commands_say_a_sentence(original, tmp_path):
    """Damage of several kinds, each met by another command."""
    rng = np.random.default_rng(6)
    out = tmp_path / "out"
    commands = (
        ("info",),
        ("export", "-o", f"{out}.csv"),
        ("peaks",),
        ("hotspots",),
        ("plot", "-o", f"{out}.png"),
        ("animate", "-o", f"{out}.gif"),
        ("forces",),
    )
    path = tmp_path / "run.h5"
    chosen = [edit for k, edit in enumerate(edits(original, rng)) if k % 9 == 0]
    refused = 0
    for k, (word, change) in enumerate(chosen):
        shutil.copy(original, path)
        with h5py.File(path, "r+") as file:
            change(file)
        if not isinstance(outcome(path), str):
            continue  # drawing what is good takes long
        name, *rest = commands[k % len(commands)]
        code, text = call(name, path, *rest)
        assert code == 2, f"{name}, {word}: {text}"
        assert "internal error" not in text, f"{name}, {word}: {text}"
        refused += 1
    assert refused > 7


def test_a_file_of_another_program_with_additions_is_read(original, tmp_path):
    path = tmp_path / "run.h5"
    shutil.copy(original, path)
    with h5py.File(path, "r+") as file:
        file["notes"] = "mine"
    assert checksums.sealed(path) is None
    for one, other in zip(everything(path), everything(original), strict=True):
        np.testing.assert_array_equal(one, other)
