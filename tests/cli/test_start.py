"""What a start loads: the time of a short command is that of its imports."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

import jousto
from jousto.cli import group as cli

ROOT = Path(__file__).parents[2]
PENDULUM = ROOT / "examples" / "flexible_pendulum.yaml"
SWING = """
bodies: [{name: ball, mass: 500 g, inertia: [1e-4, 1e-4, 1e-4], center: [0, -1 m, 0]}]
joints: [{type: revolute, name: pivot, a: ground.origin, b: ball.origin, axis: [0, 0, 1]}]
gravity: [0, -9.81, 0]
sensors: [{type: position, name: place, marker: ball.origin}]
simulation: {t_end: 10, solver: {type: RK4, step: 1 ms}}
"""
# pictures, results, tables, units beyond the usual ones, and what analyses need
ALWAYS = {
    "h5py",
    "matplotlib",
    "meshio",
    "pandas",
    "pint",
    "pycparser",
    "rich.console",
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.signal",
    "scipy.spatial",
    "scipy.special",
    "scipy.stats",
    "skfem",
}

COUNTED = """
import json, subprocess, sys
sys.argv = ["jousto", *json.loads(sys.argv[1])]
from jousto.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
def below(kind):
    return {kind}.union(*map(below, type.__subclasses__(kind)))
names = [name for name in sys.modules if name.startswith("jousto")]
made = [kind for kind in below(object) if "__dataclass_params__" in vars(kind)]
print()
print(json.dumps([[*sys.modules], len(names), len(made)]))
"""
# command: largest numbers of modules of jousto and of generated dataclasses, and the packages of
# which nothing may be loaded. The time of a start follows these numbers.
SHOWN = ("h5py", "matplotlib", "meshio", "pandas", "pint", "pycparser", "skfem")
BUDGETS: dict[str, tuple[int, int, tuple[str, ...]]] = {
    "--help": (40, 26, SHOWN),
    "--version": (14, 8, SHOWN),
    "check SWING": (278, 154, (*SHOWN, "scipy.linalg", "scipy.sparse", "jousto.recovery")),
    "check PENDULUM": (382, 224, (*SHOWN, "jousto.recovery", "scipy.optimize")),
    "run SWING": (316, 170, (*SHOWN[1:], "scipy.linalg", "scipy.sparse")),
    "info RESULT": (222, 156, (*SHOWN[1:], "yaml")),
    "plot RESULT place -o PICTURE": (102, 136, ("meshio", "pandas", "pint", "pycparser", "skfem")),
    "schema": (517, 321, SHOWN[1:]),
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A model of a rigid body and its results."""
    folder = tmp_path_factory.mktemp("start")
    model = folder / "swing.yaml"
    model.write_text(SWING, encoding="utf-8")
    names = {"SWING": "swing.yaml", "RESULT": "swing.h5", "PICTURE": "swing.png"}
    return {"PENDULUM": str(PENDULUM), **{key: str(folder / name) for key, name in names.items()}}


@pytest.mark.parametrize("command", BUDGETS)
def test_a_command_loads_no_more_than_its_budget(command, files):
    if "RESULT" in command and not Path(files["RESULT"]).exists():
        subprocess.run([sys.executable, "-m", "jousto", "run", files["SWING"]], check=True)
    words = [files.get(word, word) for word in command.split()]
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, json.dumps(words)],
        capture_output=True,
        text=True,
        check=True,
    )
    modules, own, generated = json.loads(done.stdout.splitlines()[-1])
    most, most_generated, none = BUDGETS[command]
    assert modules, "or this test looks at nothing"
    assert not [name for name in modules for one in none if f"{name}.".startswith(f"{one}.")]
    assert own <= most
    assert generated <= most_generated


def loaded(code: str) -> set[str]:
    """Return the modules that a fresh Python has loaded after some lines."""
    code += "\nimport sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def checked(model: Path) -> set[str]:
    return loaded(
        f"from jousto.cli.group import app\ntry: app(['check', {str(model)!r}])\n"
        "except SystemExit as end: assert end.code == 0"
    )


def test_check_of_rigid_bodies_loads_neither_scipy_nor_the_reduction(tmp_path):
    model = tmp_path / "swing.yaml"
    model.write_text(SWING, encoding="utf-8")
    found = checked(model)
    heavy = {"scipy.linalg", "scipy.sparse", "jousto.reduction.modes.eigen", "jousto.recovery"}
    assert not (ALWAYS | heavy) & found
    assert not [name for name in found if name.startswith("jousto.cli.mon")]


def test_check_of_a_part_loads_only_what_its_reduction_needs():
    found = checked(PENDULUM)
    assert not (ALWAYS | {"jousto.recovery", "jousto.simulation.running.simulate"}) & found
    assert "scipy.sparse" in found, "or this test looks at nothing"


def test_importing_jousto_loads_nothing_else():
    found = loaded("import jousto")
    assert not {"numpy", "scipy", "pydantic", "jousto.parts", "jousto.model"} & found
    found = loaded("import jousto as jo; jo.Mechanism")
    assert not (ALWAYS | {"scipy.linalg", "scipy.sparse", "pydantic", "jousto.model"}) & found


def test_every_listed_command_is_offered_and_the_other_way_round():
    for place in set(cli.PLACES.values()):
        importlib.import_module(f"jousto.cli.{place}")
    assert set(cli.OFFERED) == set(cli.PLACES)


def test_the_version_is_that_of_the_package():
    assert jousto.__version__ == importlib.import_module("importlib.metadata").version("jousto")
