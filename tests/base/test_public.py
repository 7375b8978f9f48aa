"""The public names: how many, lazily loaded, documented, with clean help."""

from __future__ import annotations

import importlib
import inspect
import pydoc
import re
import subprocess
import sys
from operator import attrgetter
from pathlib import Path

import pytest

import jousto as jo
import session
from jousto.base.lazy_exports import Room, public_names
from jousto.base.renames import ARGUMENTS, ATTRIBUTES, RENAMED

ROOT = Path(__file__).parents[2]
STUB = ROOT / "src" / "jousto" / "__init__.pyi"


def test_the_face_is_small() -> None:
    assert len(jo.__all__) <= 126  # of these 20 are rooms
    assert len(STUB.read_text(encoding="utf-8").splitlines()) < 350


def test_every_public_name_occurs_in_the_documentation() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]  # the list of the API lies deeper
    words = set(re.findall(r"\w+", "\n".join(page.read_text(encoding="utf-8") for page in pages)))
    assert [x for x in session.public() if x.rpartition(".")[2] not in words] == []


def test_help_of_every_public_name_is_clean() -> None:
    wrong = []
    for place, thing in session.public().items():
        if place == "jo.ground":  # an object: help is that of its class
            continue
        text = pydoc.plain(pydoc.render_doc(thing))
        if not inspect.getdoc(thing):
            wrong.append(f"{place}: no docstring")
        wrong += [f"{place}: {junk}" for junk in re.findall(r"Any = <.*|.* at 0x.*", text)]
    assert not wrong, "\n".join(wrong)


def test_the_rooms_list_their_names() -> None:
    rooms = {name: room for name in jo.__all__ if isinstance(room := getattr(jo, name), Room)}
    assert {"fatigue", "gauges", "mesh", "monitor", "planar", "sections", "twin"} <= set(rooms)
    for name, room in rooms.items():
        assert dir(room) == room.__all__ == sorted(room.__all__)
        assert inspect.getdoc(room), name
    # a file of the same name does not hide a function
    assert callable(jo.monitor.watch) and callable(jo.simulation.kinematics)


def test_every_room_is_imported_by_its_public_name() -> None:
    """As ``import jousto.gauges`` does, in a process that has imported nothing else."""
    rooms = [name for name in jo.__all__ if isinstance(getattr(jo, name), Room)]
    for name in rooms:
        lines = (
            f"import jousto.{name}",
            f"import jousto.{name} as room",
            f"assert jousto.{name} is room",
            f"from jousto.{name} import {getattr(jo, name).__all__[0]}",
        )
        done = subprocess.run(
            [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{name}: {done.stderr}"
    assert {"gauges", "twin", "monitor"} <= {*rooms}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("plot_campbell", "plot(...)"),
        ("write_mesh", "write(...)"),
        ("rainflow", "fatigue.rainflow"),
        ("read_record", "gauges.read_record"),
    ],
)
def test_a_name_that_has_moved_says_where_to(old: str, new: str) -> None:
    with pytest.raises(AttributeError, match=re.escape(f"jousto.{old} is now jo.{new}")):
        getattr(jo, old)


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_a_name_that_has_changed_says_what_it_is_now(old: str, new: str) -> None:
    room, _, name = old.rpartition(".")
    with pytest.raises(AttributeError, match=f"^{re.escape(f'{old} is now {new}')}$"):
        getattr(importlib.import_module(room), name)
    assert new in public_names()


@pytest.mark.parametrize("function", ARGUMENTS)
def test_an_argument_that_has_changed_says_what_it_is_now(function: str) -> None:
    (call,) = (place for place in public_names() if place.endswith(f".{function}"))
    for old, new in ARGUMENTS[function].items():
        with pytest.raises(jo.InputError, match=f"^{function}: {old}= is now {new}=$"):
            attrgetter(call.removeprefix("jo."))(jo)(**{old: None})


@pytest.mark.parametrize("place", ATTRIBUTES)
def test_an_attribute_that_has_changed_says_what_it_is_now(place: str) -> None:
    kind = attrgetter(place.removeprefix("jousto."))(jo)
    thing = object.__new__(kind)
    for old, new in ATTRIBUTES[place].items():
        name = kind.__name__
        with pytest.raises(AttributeError, match=f"^{name}.{old} is now {name}.{new}$"):
            getattr(thing, old)
        assert hasattr(kind, new) or new in kind.__annotations__
    with pytest.raises(AttributeError, match=f"'{name}' object has no attribute 'nonsense'"):
        thing.nonsense  # noqa: B018


def test_a_name_that_never_was_is_not_there() -> None:
    for thing in (jo, jo.fatigue):
        with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
            thing.nonsense  # noqa: B018
    assert not hasattr(jo, "__wrapped__")


def test_a_misspelt_name_suggests_the_nearest() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Revolut'; did you mean 'Revolute'"):
        jo.Revolut  # noqa: B018
    with pytest.raises(AttributeError, match="'rainflo'; did you mean 'rainflow'"):
        jo.fatigue.rainflo  # noqa: B018


def test_no_message_names_what_is_not_there() -> None:
    """Messages and docstrings name functions as users write them: ``jo.room.name``."""
    home, gone = Path(str(jo.__file__)).parent, []
    for file in sorted(home.rglob("*.py")):
        for place in set(re.findall(r"\bjo\.([A-Za-z_]\w*(?:\.\w+)*)", file.read_text("utf-8"))):
            try:
                attrgetter(place)(jo)
            except AttributeError as error:
                gone.append(f"{file.relative_to(home)}: jo.{place}: {error}")
    assert not gone, "\n".join(gone)
