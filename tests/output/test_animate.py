"""animate and still: films, pictures, views and what they refuse."""

from __future__ import annotations

import base64
import json
import re
import shutil
import signal
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from jousto.mechanism.bodies.shapes import sphere
from jousto.output.scenes.backdrop import new_picture
from jousto.output.scenes.film import Palette, find_ffmpeg
from jousto.output.scenes.stage import make_stage
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import styled
from output.runs import spatial, swing


def test_gif_runs_at_the_speed_asked_for(tmp_path: Path) -> None:
    done: list[tuple[int, int]] = []
    path = jo.animate(
        swing(),
        tmp_path / "a.gif",
        speed=0.5,
        fps=25,
        trail="tip",
        progress=lambda k, n: done.append((k, n)),
    )
    with Image.open(path) as film:
        # 0.4 s at half speed: 0.8 s and 20 steps of 1/25 s
        assert film.n_frames == 21
        assert film.info["duration"] == 40
        assert film.info["loop"] == 0
        frames = []
        for k in (0, 20):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), dtype=int))
    assert done == [(k + 1, 21) for k in range(21)]
    assert frames[0][0, 0].tolist() == [255, 255, 255]
    assert np.abs(frames[1] - frames[0]).max() > 100  # it moves


def test_a_gif_cannot_have_every_rate_but_keeps_the_speed(tmp_path: Path) -> None:
    # 30 frames per second are 3.33 hundredths of a second: 3 are taken
    with Image.open(jo.animate(swing(), tmp_path / "a.gif", fps=30)) as film:
        assert film.info["duration"] == 30
        assert (film.n_frames - 1) * 0.03 == pytest.approx(0.4, abs=0.03)


@pytest.mark.parametrize("speed", [0.1, 1e-12, 1e-320])
def test_too_many_frames_are_sped_up_with_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, speed: float
) -> None:
    """The number of frames for 1e-320 is no finite number."""
    from jousto.output.scenes.film import MOST_FRAMES

    monkeypatch.setitem(MOST_FRAMES, "gif", 12)
    with pytest.warns(jo.JoustoWarning, match=r"more than 12 frames; it runs at 0.\d+ times"):
        path = jo.animate(swing(), tmp_path / "a.gif", speed=speed)
    with Image.open(path) as film:
        assert film.n_frames == 12


def test_default_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert jo.animate(swing(), speed=4) == Path("swing.gif")
    assert (tmp_path / "swing.gif").stat().st_size > 1000


def test_html_is_complete_in_itself(tmp_path: Path) -> None:
    path = jo.animate(swing(), tmp_path / "a.html", speed=2)
    page = path.read_text(encoding="utf-8")
    assert "http" not in page
    frames = json.loads(re.search(r"const frames = (\[.*?\]);", page).group(1))  # type: ignore[union-attr]
    assert len(frames) == 6
    assert 'max="5"' in page
    assert base64.b64decode(frames[0])[8:12] == b"WEBP"
    assert not re.search(r"TITLE|COUNT|WIDTH|FPS|FRAMES", page)


def test_mp4_without_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with pytest.raises(jo.InputError, match=r"needs the program ffmpeg.*write a .gif or .html"):
        jo.animate(swing(), tmp_path / "a.mp4")


def test_mp4(tmp_path: Path) -> None:
    try:
        find_ffmpeg(tmp_path / "a.mp4")
    except jo.InputError:
        pytest.skip("no ffmpeg here")
    path = jo.animate(swing(), tmp_path / "a.mp4")
    assert path.read_bytes()[4:8] == b"ftyp"


def test_a_failing_ffmpeg_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "ffmpeg"
    script.write_text("#!/bin/sh\necho no such codec >&2\nexit 3\n")
    script.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda name: str(script))
    pipe = getattr(signal, "SIGPIPE", None)
    before = signal.signal(pipe, signal.SIG_DFL) if pipe else None  # as Gmsh leaves it
    try:
        with pytest.raises(jo.InputError, match="ffmpeg failed: no such codec"):
            jo.animate(swing(), tmp_path / "a.mp4")
        assert not pipe or signal.getsignal(pipe) == signal.SIG_DFL
    finally:
        if pipe:
            signal.signal(pipe, before)


@pytest.mark.parametrize("name", ["a.png", "a.svg"])
def test_still_through_animate(name: str, tmp_path: Path) -> None:
    one = jo.animate(swing(), tmp_path / name, stills=(0.0, 0.2, 0.4), trail="tip")
    other = jo.still(swing(), tmp_path / f"b{name}", times=3, trail=["tip"])
    assert one.read_bytes() == other.read_bytes()


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
def test_a_body_without_joints_flies_in_a_film(tmp_path: Path) -> None:
    body = jo.RigidBody("body", 1.0, (0.1, 0.1, 0.1), velocity=(1, 0, 0))
    run = jo.simulate(jo.compile(jo.Mechanism(body)), 0.2, output_step=0.05)
    with Image.open(jo.animate(run, tmp_path / "a.gif")) as film:
        assert film.n_frames > 1


def test_bodies_are_where_they_are() -> None:
    # data coordinates of the picture are world coordinates: x to the right, z up
    stage = make_stage(swing(), np.array([0.0, 0.4]), scale=1.0, view=None, trail=None)
    assert stage.view.plane == "xz"
    for i, instant in ((0, 0), (1, -1)):
        hand = stage.at(i).x[1]
        # the ball around the centre of mass has its vertices after those of the rod
        ball = hand[-len(np.unique(sphere(1.0).triangles.reshape(-1, 3), axis=0)) :, :2]
        middle = 0.5 * (ball.min(axis=0) + ball.max(axis=0))
        np.testing.assert_allclose(middle, swing()["tip"][instant, [0, 2]], atol=2e-3)


@pytest.mark.parametrize("view", [None, "xy", View((1, 1, 1))])
def test_lengths_are_equal_in_all_directions(view: View | str | None) -> None:
    with styled():
        stage = make_stage(spatial(), np.linspace(0, 0.8, 5), scale=1.0, view=view, trail=None)
        figure, ax = new_picture(stage, "", "")
    inches = figure.get_size_inches() * ax.get_position().size
    span = np.array([np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())])
    assert inches[0] / span[0] == pytest.approx(inches[1] / span[1], rel=1e-12)
    low, high = np.array([ax.get_xlim(), ax.get_ylim()]).T
    for i in range(5):
        for x in stage.at(i).x:
            assert np.all(x[:, :2] > low)
            assert np.all(x[:, :2] < high)


@pytest.mark.parametrize(
    ("flat", "gravity", "plane"),
    [
        (2, None, "xy"),
        (1, None, "xz"),
        (0, None, "yz"),
        (2, (0, -9.81, 0), "xy"),
        (0, (0, -9.81, 0), "zy"),
        (2, (-9.81, 0, 0), "yx"),
        (None, None, ""),
        (2, (0, 0, -9.81), ""),  # motion on the floor is seen from above, not from the side
    ],
)
def test_plane_motion_is_seen_straight_on(
    flat: int | None, gravity: tuple[float, ...] | None, plane: str, rng: np.random.Generator
) -> None:
    points = rng.uniform(-1.0, 1.0, size=(50, 3))
    if flat is not None:
        points[:, flat] = 0.3
    view = choose_view(None, points, gravity)
    assert view.plane == plane
    np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(view.axes) == pytest.approx(1.0)
    # down is down, and no gravity has no direction
    down = np.array(gravity or (0.0, 0.0, 0.0))
    assert (view.project(down)[1] < 0.0) == (gravity is not None)


def test_view_keeps_the_right_hand_and_refuses_nonsense() -> None:
    for plane in ("xy", "xz", "yz"):
        assert View.on(plane).plane == plane
    with pytest.raises(jo.InputError, match="up is parallel to the direction"):
        View((0, 0, 2), up=(0, 0, -1))
    with pytest.raises(jo.InputError, match=r"direction is \(0, 0, 0\)"):
        View((0, 0, 0))
    with pytest.raises(jo.InputError, match="view: is 'xyz', must be 'xy', 'xz', 'yz' or a View"):
        choose_view("xyz", np.eye(3), None)


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match=r"'.avi' is not a format.*known: .gif, .mp4, .html"):
        jo.animate(swing(), tmp_path / "a.avi")
    with pytest.raises(jo.InputError) as error:
        jo.animate(swing(), tmp_path / "a.gif", scale=-1, trail=("tpi", "pin"))
    first, *others = [p.message for p in error.value.problems]
    assert first.startswith("scale is -1")
    assert others == [
        "no sensor 'tpi'; did you mean 'tip'?",
        "sensor 'pin' is not a position but in N, N m",
    ]
    with pytest.raises(jo.InputError, match="speed is 0"):
        jo.animate(swing(), tmp_path / "a.gif", speed=0)
    with pytest.raises(jo.InputError, match="5 s is outside the run"):
        jo.still(swing(), tmp_path / "a.png", times=[0.1, 5.0])
    assert list(tmp_path.iterdir()) == []


def test_palette_keeps_the_commonest_colours_exactly(rng: np.random.Generator) -> None:
    frame = np.full((60, 60, 3), 255, dtype=np.uint8)
    frame[20:30] = (28, 95, 168)
    frame[38] = (247, 251, 251)  # nearly white must not replace white, though it is nearer to the
    frame[40] = (252, 252, 253)  # middle of the box of colours that white is in
    frame[50] = rng.integers(0, 256, size=(60, 3))
    back = np.asarray(Palette([frame]).index(frame).convert("RGB"))
    np.testing.assert_array_equal(back[:40], frame[:40])
    assert np.abs(back.astype(int) - frame).max() < 90


def test_the_top_of_a_scale_of_colours_is_not_lost_among_many_shades() -> None:
    frame = np.full((200, 300, 3), 255, dtype=np.uint8)
    # hundreds of greenish blues, and a few pixels of other colours
    y, x = np.mgrid[:180, :256]
    frame[:180, :256] = np.stack([y // 2, x, 128 + (x + y) % 100], axis=2)
    rare = [(199, 40, 45), (238, 138, 50), (245, 213, 71), (30, 160, 40), (160, 30, 160)]
    frame[190, : len(rare)] = rare
    back = np.asarray(Palette([frame]).index(frame).convert("RGB"))
    off = np.abs(back.astype(int) - frame.astype(int)).max(axis=2)
    assert off[190].max() < 16
    assert off[:180, :256].mean() < 24
