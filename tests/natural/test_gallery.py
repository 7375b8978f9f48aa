"""verify over the machines of the examples: all agree, by two formulations or by two methods."""

from __future__ import annotations

from pathlib import Path

import pytest

from natural.gallery import FOLDER, MACHINES, motion

PAGE = Path(__file__).parents[2] / "docs" / "verify-gallery.md"
STICKS, BEAMS = "does not support StickSlip", "does not support exact beams"
UNKNOWN = {
    "belt_friction.yaml": STICKS,
    "lcd_robot": STICKS,
    "steel_strip.yaml": BEAMS,
    "beam_benchmarks": BEAMS,
    "robot_hose": BEAMS,
    "spin_up.yaml": "does not support second-order displacements",
    "slewing_limit": "does not stop at events",
}
WEIGHTLESS = "study_pendulum"  # all of its bob in a point: 1e-9 kg m2
# vibrations that these steps do not resolve; the examples damp them away
COARSE = {"monitor.yaml", "rod_at_speed", "rail_wheel, the wheel"}


def test_no_machine_is_missing() -> None:
    """Every example that declares a mechanism; another frame of beams in a plane is none."""
    scripts = {path.stem for path in FOLDER.glob("*.py") if "Mechanism(" in path.read_text("utf-8")}
    files = {path.name for path in FOLDER.glob("*.yaml")}
    shown = {name.split(",")[0] for name in MACHINES}
    # the same machines as their files: a truth of finer mesh, loads and speeds of their own
    # contacts have no second formulation: tests/model/test_contact_steps.py has the quadruped,
    # tests/model/test_track_contact.py balls on beams; nor have states with equations of their own
    twins = {
        "ball_on_beam",
        "bowl_feeder",
        "bucket_stop",
        "door_latch",
        "gripper",
        "humanoid",
        "crane_hydraulics",
        "quadruped",
        "railway_wheel",
        "robot_axis_drive",
        "wheelset_hunting",
        "crane_twin",
        "flexible_pendulum",
        "link_arm",
        "monitor",
        "moving_load",
    }
    assert (scripts - twins) | files <= shown


def test_the_page_lists_them() -> None:
    rows = [line.split("|") for line in PAGE.read_text("utf-8").splitlines()]
    found = {row[1].strip(): row[-2].strip() for row in rows if len(row) > 6}
    for name in MACHINES:
        said = "two methods agree" if name in UNKNOWN else "agree"
        assert found[name].startswith(said), name


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_machines_agree(name: str) -> None:
    shown = MACHINES[name]
    found = shown.verified()
    assert found.agrees, found
    assert bool(found.unknown) == (name in UNKNOWN), found
    if found.unknown:
        assert any(UNKNOWN[name] in what for what in found.unknown)
    else:
        assert all(row.meets for row in motion(shown, found)) == (name not in COARSE), found


def test_a_body_without_inertia_agrees() -> None:
    """The pivot meets 1e-9 kg across the rod, where its other constraints do not hold."""
    found = MACHINES[WEIGHTLESS].verified()
    assert found.agrees, found
    assert found.iterations < 3
    assert found.residual < 1e-13
    assert all(row.order == pytest.approx(2.0, abs=0.1) for row in found.rows)
