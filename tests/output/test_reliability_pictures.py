"""Pictures of reliability: what stands on them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jousto as jo
from design.limit_states import TEN, normal


def texts(figure):
    return [ax.get_xlabel() for ax in figure.axes]


def test_importance_and_sensitivities():
    found = jo.design.form(*TEN["roof"])
    left, right = jo.plot(found).axes
    names = [label.get_text() for label in left.get_yticklabels()]
    assert names == sorted(found.importance, key=lambda name: -found.importance[name])
    widths = [bar.get_width() for bar in left.patches]
    assert widths == pytest.approx(sorted(found.importance.values(), reverse=True))
    assert len(right.patches) == 2 * len(names)
    # of variables whose moments are no parameters there is the importance alone
    two = [
        normal("a", 0, 1),
        jo.design.Conditional("b", lambda x: TEN["convex"][1][0].distribution),
    ]
    alone = jo.design.form(lambda x: 20.0 - x["a"] - x["b"] * 2.0, jo.design.Rosenblatt(two))
    assert texts(jo.plot(alone)) == ["importance"]


def test_a_probability_settles(tmp_path):
    state = jo.design.LimitState(lambda x: 2.0 - x["a"], vectorised=True)
    found = jo.design.importance_sampling(state, [normal("a", 0, 1)], variation=0.05)
    figure = jo.plot(found, path=tmp_path / "settling.png")
    (line,) = figure.axes[0].lines
    np.testing.assert_array_equal(line.get_ydata(), found.history[:, 1])
    assert (tmp_path / "settling.png").is_file()
    levels = jo.design.subset_simulation(state, [normal("a", 0, 1)], samples=500)
    assert texts(jo.plot(levels)) == ["threshold of G"]
    none = jo.design.monte_carlo(lambda x: 9.0 - x["a"], [normal("a", 0, 1)], samples=50)
    assert texts(jo.plot(none)) == ["samples"]


def test_designs_and_the_error_of_their_tangents():
    found = jo.design.rbdo(
        lambda d: d["a"],
        {
            "near": lambda x: x["a"] - 3.0,
            "far": lambda x: x["a"] + 90.0,
            "never": lambda x: 1.0 + math.exp(0.1 * x["a"]),
        },
        [normal("a", 10, 1)],
        {"a": (0.0, 20.0)},
        2.0,
        method="ria",
    )
    left, right = jo.plot(found).axes
    assert len(left.lines[0].get_ydata()) == len(found.history)
    assert [text.get_text().strip() for text in right.texts] == [">", ">"]
    assert [bar.get_width() for bar in right.patches] == pytest.approx([2.0, 6.0, 6.0], rel=1e-6)
    checked = jo.design.check_linearisation(found, samples=200)
    (ax,) = jo.plot(checked).axes
    assert [label.get_text() for label in ax.get_yticklabels()] == list(checked.names)
