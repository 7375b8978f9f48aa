"""Function `view`: a run, a machine or a part in the browser, a notebook cell, or a file."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.progress import in_notebook
from jousto.viewer.file_watch import Watched
from jousto.viewer.queries import Answers
from jousto.viewer.server import Server
from jousto.viewer.standalone import FRAMES, page, write_page
from jousto.viewer.viewable import scenes_of

if TYPE_CHECKING:
    from jousto.fatigue.miner.damage_field import DamageField
    from jousto.mechanism.mechanism import Mechanism
    from jousto.mesh.mesh import Mesh
    from jousto.model.model import Model
    from jousto.parts.part import Part
    from jousto.reduction.reduced import ReducedPart
    from jousto.scene.scene import Scene
    from jousto.simulation.modes.linear import MechanismModes
    from jousto.simulation.results.solution import Solution

HEIGHT = 560  # height of a notebook cell, pixels
MOST = 4  # overlaid objects


class View:
    """Page with its address, its server, and its form as a file.

    Result of `view`; ends with `close`, or with the program.
    """

    def __init__(self, answers: Answers, *, port: int = 0, embed: bool = False) -> None:
        self._answers, self._embed = answers, embed
        self._server = None if embed else Server(answers, port)

    def __repr__(self) -> str:
        where = "embedded" if self._server is None else self.address
        return f"<View {self._answers.title!r}: {where if self.running else 'closed'}>"

    @property
    def address(self) -> str:
        """Address of the page on this computer; anyone with it can see the page.

        Raises
        ------
        InputError
            If the page is embedded in a notebook and has no address.
        """
        if self._server is None:
            raise InputError(Problem("view", "an embedded page has no address"))
        return self._server.address

    @property
    def running(self) -> bool:
        """Whether the server answers requests."""
        return self._server is None or self._server.running

    def open(self) -> bool:
        """Open the page in the browser; return whether a browser exists."""
        return self._server is not None and self._server.open()

    def wait(self) -> None:
        """Wait until the page is closed, or Ctrl-C; for the end of a script."""
        if self._server is not None:
            self._server.wait()

    def close(self) -> None:
        """Close the server; an open page keeps its data."""
        if self._server is not None:
            self._server.close()

    def save(self, path: str | Path, *, frames: int = FRAMES) -> Path:
        """Write the page as one self-contained file and return its path.

        Parameters
        ----------
        path : path
            Ends with .html.
        frames : int
            Largest number of instants of each run.

        Raises
        ------
        InputError
            For another ending, a page that would be too large, or a file that cannot be written.
        """
        scenes, titles = self._answers.scenes, self._answers.titles
        return write_page(scenes, path, frames=frames, titles=titles)

    def _repr_html_(self) -> str:
        """Return the page as HTML of a notebook cell."""
        style = f"width: 100%; height: {HEIGHT}px; border: 0"
        if self._server is None:
            content = html.escape(self._answers.page().decode())
            return f'<iframe style="{style}" srcdoc="{content}"></iframe>'
        if not self.running:
            return f"<em>{html.escape(repr(self))}</em>"
        note = (
            "The page comes from this computer. Of a notebook that runs elsewhere, or for one that "
            "is sent, jo.view(..., embed=True) puts it into the cell."
        )
        frame = f'<iframe style="{style}" allow="fullscreen" src="{html.escape(self.address)}">'
        return f'{frame}</iframe><div style="opacity: 0.6">{note}</div>'


@explained
def view(
    thing: str | Path | Solution | Mechanism | Model | ReducedPart | Part | Mesh | MechanismModes,
    *others: Any,
    open: bool = True,
    damage: DamageField | Sequence[DamageField] | None = None,
    modes: bool = False,
    port: int = 0,
    embed: bool = False,
) -> View:
    """Show an object on a page in the browser, with rotation, playback and queries.

    Parts, machines and runs are drawn with their shapes, deformation and stress (``x = R + A (x0 +
    sum phi_j p_j)``, ``sigma = sum Sigma_j p_j``); displayed numbers are computed in double
    precision from the run. A server on this computer provides the page; it answers only requests
    with the random token of its address.

    Parameters
    ----------
    thing : object or path
        A run, a mechanism or compiled model, a part, reduced part or mesh, modes of a machine, or
        the path of results, a model, a reduced part or a mesh.
    *others : objects or paths
        Up to three objects that are overlaid for comparison.
    open : bool
        Open the browser. In a notebook the page is shown in the cell instead.
    damage : DamageField or sequence of these, optional
        Damage of bodies of the run, to be shown in colours.
    modes : bool
        Show the modes of vibration of the machine about its rest position.
    port : int
        Port of the server, 0 for any free port.
    embed : bool
        In a notebook, put the whole page into the cell, without a server, for notebooks that are
        sent to others or run on other computers.

    Returns
    -------
    View
        ``.address``, ``.save(path)``, ``.wait()`` at the end of a script, ``.close()``.

    Raises
    ------
    InputError
        If an object cannot be shown, the port is taken, or the page was not built.

    Examples
    --------
    ``jo.view(run)``, ``jo.view("crane.h5").save("crane.html")``, ``jo.view(before, after)``
    """
    things = (thing, *others)
    problems = Problems()
    whole: Any = port
    if isinstance(whole, bool) or not isinstance(whole, int) or not 0 <= whole < 65536:
        problems.add("view", f"port is {port!r}, must be a whole number from 0 to 65535")
    switches: dict[str, Any] = {"open": open, "modes": modes, "embed": embed}
    for name, value in switches.items():
        if not isinstance(value, bool):
            problems.add("view", f"{name} is {value!r}, must be True or False")
    if len(things) > MOST:
        problems.add("view", f"{len(things)} things, must be up to {MOST}")
    problems.raise_if_any()
    made = View(answers_of(things, damage=damage, modes=modes), port=port, embed=embed)
    if open and not embed and not in_notebook():
        made.open()
    return made


def answers_of(things: Sequence[Any], *, frames: int = FRAMES, **how: Any) -> Answers:
    """Return the answers for objects or files; see `scenes_of`."""
    paths = [Path(thing) for thing in things if isinstance(thing, str | Path)]

    def anew() -> list[Scene]:
        if how.get("damage"):
            message = "the damage belongs to the previous run; restart the command"
            raise InputError(Problem("view", message))
        return scenes_of(things, **how)

    watched = Watched(paths, anew)
    scenes = scenes_of(things, **how)
    titles = number_titles(names_of(things, scenes))

    def whole() -> bytes:
        return page(made.scenes, frames=frames, titles=titles)

    made = Answers(scenes, titles, whole, watched if paths else None)
    return made


def names_of(things: Sequence[Any], scenes: Sequence[Scene]) -> list[str]:
    """Return distinct names of objects: file names, else titles."""
    if len(things) == 1:
        return [scenes[0].title]
    found, files = [], []
    for thing, scene in zip(things, scenes, strict=True):
        run = scene.run
        where = str(thing) if isinstance(thing, str | Path) else run.where if run else ""
        files.append(where if where and Path(where).is_file() else "")
        found.append(Path(where).name if files[-1] else scene.title)
    # equal file names in several folders
    return [
        file if file and found.count(name) > 1 else name
        for file, name in zip(files, found, strict=True)
    ]


def number_titles(titles: Sequence[str]) -> list[str]:
    """Return titles, with numbers added to equal ones.

    Examples
    --------
    >>> number_titles(["crane", "crane", "arm"])
    ['crane 1', 'crane 2', 'arm']
    """
    number: dict[str, int] = {}
    found = []
    for title in titles:
        number[title] = number.get(title, 0) + 1
        found.append(title if titles.count(title) == 1 else f"{title} {number[title]}")
    return found
