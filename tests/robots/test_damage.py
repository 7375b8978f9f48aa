"""Damaged files of robots: an error of ours or none, and no other file is opened."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Tree, mechanism, read_robot
from robots.damage import damaged, watched
from robots.machines import ARM, CREATURE, GRIPPER, NESTED_SDF, SCARA, SCARA_SDF, WORKS

FILES = (ARM, SCARA, GRIPPER, CREATURE, SCARA_SDF, WORKS, NESTED_SDF)
MANY = int(os.environ.get("JOUSTO_DAMAGED", "2000"))  # 10,000 take minutes


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("count", [250, pytest.param(MANY, marks=pytest.mark.slow)])
def test_damaged_files_are_told_in_sentences(count: int, tmp_path: Path) -> None:
    """Files with lost and doubled letters, foreign numbers and elements."""
    path = tmp_path / "robot.xml"
    rng = np.random.default_rng(count)
    for text in FILES:
        path.write_text(text, encoding="utf-8")
        Tree(mechanism(read_robot(path)))  # loads what is loaded on first use
    refused = 0
    with watched() as seen:
        for i in range(count):
            path.write_bytes(damaged(FILES[i % len(FILES)], rng))
            try:
                robot = read_robot(path)
                tree = Tree(replace(robot, loops=()))
                assert np.isfinite(tree.mass_matrix(tree.initial)).all()
                mechanism(robot)
            except jo.InputError as error:
                refused += 1
                assert all(problem.message for problem in error.problems)
    assert {name for name in seen if Path(name).parent != tmp_path} == set()
    assert 0.2 * count < refused < count
