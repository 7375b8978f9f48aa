"""Saved parts: bit for bit, and a clear sentence for every damaged file."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest

from jousto.base.errors import InputError
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from reduction.bodies import bent, lattice, pendulum

CASES = {
    "beam": lambda: reduce(bent(), CraigBampton(("start", "end"), modes=3)),
    "lumped": lambda: reduce(pendulum(), FreeFree(modes=2)),
    "solid": lambda: reduce(lattice(), CraigBampton(("foot",), modes=3)),
}


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "part.h5"
    CASES["beam"]().save(path)
    return path


@pytest.mark.parametrize("name", CASES)
def test_round_trip_is_exact(name: str, tmp_path: Path) -> None:
    a = CASES[name]()
    a.save(tmp_path / "a.h5")
    b = ReducedPart.load(str(tmp_path / "a.h5"))
    for key in ("name", "interfaces"):
        assert getattr(a, key) == getattr(b, key)
    assert dict(a.node_sets) == dict(b.node_sets)
    assert dict(a.provenance) == dict(b.provenance)
    for key in ("nodes", "elements", "modes", "frequencies"):
        assert getattr(a, key).tobytes() == getattr(b, key).tobytes()
        assert getattr(a, key).dtype == getattr(b, key).dtype
    for key in ("first_moment", "second_moment", "I3", "N0", "E"):
        assert getattr(a.invariants, key).tobytes() == getattr(b.invariants, key).tobytes()
    assert a.invariants.mass == b.invariants.mass
    # a second generation is the same file
    b.save(tmp_path / "b.h5")
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


@pytest.mark.parametrize("name", sorted(set(CASES) - {"solid"}))
def test_rotations_and_stress_are_kept_exactly(name: str, tmp_path: Path) -> None:
    a = CASES[name]()
    a.save(tmp_path / "a.h5")
    b = ReducedPart.load(tmp_path / "a.h5")
    assert a.rotations.tobytes() == b.rotations.tobytes()
    assert a.stress.labels == b.stress.labels
    assert a.stress.modes.tobytes() == b.stress.modes.tobytes()


def test_what_a_solid_does_not_have_is_not_kept(tmp_path: Path) -> None:
    a = CASES["solid"]()
    a.save(tmp_path / "a.h5")
    b = ReducedPart.load(tmp_path / "a.h5")
    assert a.rotations is None and b.rotations is None
    assert a.stress is None and b.stress is None


def test_same_reduction_same_file(tmp_path: Path) -> None:
    for name in ("a.h5", "b.h5"):
        CASES["beam"]().save(tmp_path / name)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_replaces_an_older_file_and_leaves_nothing_behind(saved: Path) -> None:
    CASES["lumped"]().save(saved)
    assert ReducedPart.load(saved).name == "pendulum"
    assert [p.name for p in saved.parent.iterdir()] == ["part.h5"]


def test_units_are_in_the_file(saved: Path) -> None:
    with h5py.File(saved) as file:
        assert file["frequencies"].attrs["unit"] == "Hz"
        assert file["invariants/second_moment"].attrs["unit"] == "kg m^2"


def test_names_with_any_character(tmp_path: Path) -> None:
    from dataclasses import replace

    a = CASES["beam"]()
    odd = "väli/piste 'ä'"
    a = replace(a, name=odd, node_sets={**a.node_sets, odd: (1,)})
    a.save(tmp_path / "a.h5")
    assert ReducedPart.load(tmp_path / "a.h5").node(odd) == 1


# ---- files that cannot be used


def edit(change: Callable[[h5py.File], None]) -> Callable[[Path], None]:
    def apply(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            change(file)

    return apply


def replace_dataset(name: str, value: object) -> Callable[[Path], None]:
    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = value

    return edit(change)


def delete(name: str) -> Callable[[Path], None]:
    return edit(lambda file: file.__delitem__(name))


def poke(name: str, value: float) -> Callable[[Path], None]:
    def change(file: h5py.File) -> None:
        array = file[name][()]
        array.flat[0] = value
        file[name][...] = array

    return edit(change)


def attribute(name: str, value: object) -> Callable[[Path], None]:
    return edit(lambda file: file.attrs.__setitem__(name, value))


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "text": (lambda p: p.write_text("not a part"), "not an HDF5 file"),
    "empty": (lambda p: p.write_bytes(b""), "not an HDF5 file"),
    "cut": (lambda p: p.write_bytes(p.read_bytes()[:-3000]), "damaged or truncated"),
    "head only": (lambda p: p.write_bytes(p.read_bytes()[:100]), "damaged or truncated"),
    "missing file": (lambda p: p.unlink(), "there is no such file"),
    "other file": (
        edit(lambda f: f.attrs.__delitem__("format")),
        "not a reduced part: it names no",
    ),
    "other format": (attribute("format", "results"), "its format is 'results'"),
    "newer": (
        attribute("version", 6),
        "version 6 of the format, this jousto reads versions up to 5",
    ),
    "no header": (delete("header"), "incomplete or damaged"),
    "bad header": (replace_dataset("header", np.zeros(5, np.uint8)), "is damaged"),
    "no modes": (delete("modes"), "modes is missing"),
    "no invariant": (delete("invariants/E"), "invariants/E is missing"),
    "no group": (delete("invariants"), "invariants/mass is missing"),
    "no stress": (delete("stress/axes"), "stress/axes is missing"),
    "shape": (replace_dataset("modes", np.zeros((2, 3, 4))), r"modes has shape \(2, 3, 4\)"),
    "type": (replace_dataset("nodes", "abc"), "nodes is not an array of numbers"),
    "NaN": (poke("modes", np.nan), r"modes\[0, 0, 0\] is nan"),
    "NaN in E": (poke("invariants/E", np.nan), r"E\[0, 0, 0, 0\] is nan"),
    "frequency": (poke("frequencies", -1.0), "a frequency is -1 Hz"),
    "element": (poke("elements", 999), "elements refer to nodes outside"),
    "fewer modes": (replace_dataset("frequencies", np.ones(3)), "must be"),
    "one digit": (poke("modes", 0.125), r"changed after writing \(wrong checksum\)"),
    "no checksum": (edit(lambda f: f.attrs.__delitem__("checksum")), "incomplete or damaged"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damaged_file(kind: str, saved: Path) -> None:
    damage, message = DAMAGE[kind]
    damage(saved)
    with pytest.raises(InputError, match=message) as error:
        ReducedPart.load(saved)
    text = str(error.value)
    assert str(saved) in text
    assert "reduce the part again and save it" in text


@pytest.mark.parametrize("start", range(0, 100, 7))
def test_any_flipped_block_is_noticed(start: int, saved: Path) -> None:
    """A file with bytes overwritten anywhere either gives the same part or an InputError."""
    good = ReducedPart.load(saved)
    data = bytearray(saved.read_bytes())
    at = len(data) * start // 100
    data[at : at + 64] = bytes(b ^ 0xA5 for b in data[at : at + 64])
    saved.write_bytes(bytes(data))
    try:
        bad = ReducedPart.load(saved)
    except InputError:
        return
    assert bad.modes.tobytes() == good.modes.tobytes()
    assert bad.invariants.E.tobytes() == good.invariants.E.tobytes()
    assert dict(bad.node_sets) == dict(good.node_sets)


def test_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        ReducedPart.load(tmp_path)
    with pytest.raises(InputError, match="is a folder, must be a file"):
        CASES["beam"]().save(tmp_path)


def test_path_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written: the folder .* does not exist; create"):
        CASES["beam"]().save(tmp_path / "nowhere" / "part.h5")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write all")
def test_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(InputError, match="cannot be written"):
            CASES["beam"]().save(tmp_path / "part.h5")
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.skipif(sys.platform != "linux", reason="limits the size of files")
@pytest.mark.parametrize("limit", [0, 1000, 9000])
def test_disk_full(limit: int, saved: Path) -> None:
    """A file that may not grow further, in a process of its own: the old file stays."""
    before = saved.read_bytes()
    script = (
        "import resource, sys\n"
        "from jousto.base.errors import InputError\n"
        "from jousto.reduction.reduced import ReducedPart\n"
        "part = ReducedPart.load(sys.argv[1])\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))\n"
        "try:\n"
        "    part.save(sys.argv[1])\n"
        "except InputError as error:\n"
        "    print(error)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, str(saved)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert run.returncode == 0, run.stderr
    assert "cannot be written: File too large" in run.stdout
    assert saved.read_bytes() == before
    assert [p.name for p in saved.parent.iterdir()] == ["part.h5"]


def test_threads_save_side_by_side(tmp_path: Path) -> None:
    part = CASES["beam"]()
    paths = [tmp_path / f"{i % 4}.h5" for i in range(16)]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(part.save, paths))
    assert len({path.read_bytes() for path in paths}) == 1
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.parametrize("kind", ["link", "external storage"])
def test_no_foreign_file_is_read(kind: str, saved: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.h5"
    with h5py.File(saved, "r+") as file, h5py.File(secret, "w") as other:
        modes = file["modes"][()]
        other["modes"] = modes
        del file["modes"]
        if kind == "link":
            file["modes"] = h5py.ExternalLink(secret, "/modes")
        else:
            raw = tmp_path / "raw"
            raw.write_bytes(modes.tobytes())
            file.create_dataset("modes", modes.shape, "f8", external=[(str(raw), 0, modes.nbytes)])
    with pytest.raises(InputError, match="another"):
        ReducedPart.load(saved)


def test_flipped_bits_are_refused_or_do_not_matter(saved: Path) -> None:
    whole, right = saved.read_bytes(), ReducedPart.load(saved)
    rng = np.random.default_rng(1)
    used = np.flatnonzero(np.frombuffer(whole, np.uint8))
    refused, read = [], []
    for at in rng.choice(used, 60):
        damaged = bytearray(whole)
        damaged[at] ^= 1 << rng.integers(8)
        saved.write_bytes(damaged)
        try:
            found = ReducedPart.load(saved)
        except InputError as error:
            refused.append(str(error))
        else:
            read.append(found)
    assert len(refused) > 50
    assert all(str(saved) in text for text in refused)
    same = [np.array_equal(found.modes, right.modes) for found in read]
    same += [np.array_equal(found.frequencies, right.frequencies) for found in read]
    assert all(same)
