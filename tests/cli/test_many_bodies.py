"""Commands on results of many bodies: what they read of a file grows with the bodies."""

from __future__ import annotations

import cProfile
import pstats
from pathlib import Path

import pytest

from cli.test_meshes import call
from viewer.test_standalone import chain

COUNTS = (2, 4, 8, 16)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """Results files of chains of elastic links, by the number of links."""
    folder = tmp_path_factory.mktemp("chains")
    for count in COUNTS:
        chain(count, folder / f"{count}.h5")
    return {count: folder / f"{count}.h5" for count in COUNTS}


def reads(command: str, result: Path) -> int:
    """Return how many pieces of a results file a command reads."""
    words = [str(result) if word == "RESULT" else word for word in command.split()]
    words = [word.replace("OUT", str(result.with_suffix(""))) for word in words]
    profile = cProfile.Profile()
    code, text = profile.runcall(call, *words)
    assert code == 0, text
    stats = pstats.Stats(profile).stats
    return sum(v[1] for k, v in stats.items() if k[0].endswith("h5py/_hl/group.py"))


@pytest.mark.parametrize(
    "command",
    ["info RESULT", "peaks RESULT", "hotspots RESULT", "plot RESULT -o OUT.png"]
    + ["export RESULT -o OUT.csv", "animate RESULT -o OUT.png"],
)
def test_the_pieces_that_a_command_reads_grow_with_the_bodies(command, results):
    """Twice the bodies, at most twice the further reads; 4 where each body reads all of them."""
    reads(command, results[2])  # loads modules
    one, two, four = (reads(command, results[count]) for count in COUNTS[1:])
    assert one > 0, "or this test looks at nothing"
    assert four - two <= 2.1 * (two - one)
