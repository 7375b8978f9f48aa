"""Rainflow counting against the standard's text, its figures and random histories."""

import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from fatigue.counting import astm, simplified
from jousto import SN, InputError
from jousto.fatigue import damage, rainflow
from jousto.fatigue.cycles.rainflow import turning_points

FIGURE_6 = [-2, 1, -3, 5, -1, 3, -4, 4, -2]  # ASTM E1049-85 (2017), figure 6
CURVE = SN(S_D=100e6, N_D=1e6, k=5)


def spectrum(triples, digits=9):
    out = Counter()
    for r, m, c in triples:
        out[round(r, digits), round(m, digits)] += c
    return {key: value for key, value in out.items() if key[0] > 0}


def triples(cycles):
    return zip(cycles.range.tolist(), cycles.mean.tolist(), cycles.count.tolist(), strict=True)


def test_astm_figure_6():
    cycles = rainflow(FIGURE_6, residue="half")
    assert cycles.sums() == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    assert cycles.open.tolist() == [-2, 1, -3, 5, -4, 4, -2]
    ignored = rainflow(FIGURE_6, residue="ignore")
    assert ignored.sums() == {4.0: 1.0}
    # the full cycle is E-F of the figure, -1 to 3
    assert (ignored.mean.tolist(), ignored.from_index.tolist()) == ([1.0], [4])
    assert FIGURE_6[int(ignored.to_index[0])] == 3


def test_repeating_history():
    # ASTM E1049-85, 5.4.5: the same history as a circle, all cycles whole; by hand 9 (5 to -4),
    # 7 (4 to -3, across the seam), 4 (-1 to 3) and 3 (1 to -2)
    cycles = rainflow(FIGURE_6, residue="repeat")
    assert cycles.sums() == {3.0: 1.0, 4.0: 1.0, 7.0: 1.0, 9.0: 1.0}


def test_damage_of_the_block():
    cycles = rainflow(25e6 * np.array(FIGURE_6, dtype=float), residue="half")
    assert damage(cycles, CURVE) == pytest.approx(2.07025146e-6, rel=1e-8)


histories = st.lists(st.integers(-8, 8), min_size=2, max_size=40)


@settings(max_examples=200, deadline=None)
@given(histories)
def test_half_is_the_standard(history):
    counted = rainflow(history, residue="half")
    assert spectrum(triples(counted)) == spectrum(astm(history))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.floats(-1, 1, width=32), min_size=2, max_size=40))
def test_repeat_is_the_simplified_method_of_the_standard(history):
    counted = rainflow(history, residue="repeat")
    mine = sorted(r for r, _, _ in triples(counted) if r > 0)
    theirs = sorted(r for r, _, _ in simplified(history) if r > 0)
    assert mine == pytest.approx(theirs)


@settings(max_examples=100, deadline=None)
@given(histories, st.integers(2, 4))
def test_repeat_is_what_every_further_repetition_adds(history, times):
    """Counting n + 1 repetitions less n of them, rest ignored, is the rule 'repeat'."""
    once = spectrum(triples(rainflow(history, residue="repeat")))
    more = Counter(spectrum(triples(rainflow(history * (times + 1), residue="ignore"))))
    more.subtract(spectrum(triples(rainflow(history * times, residue="ignore"))))
    assert {key: value for key, value in more.items() if value} == once


@settings(max_examples=100, deadline=None)
@given(histories)
def test_samples_of_cycles_are_those_of_the_history(history):
    for rule in ("half", "repeat", "ignore"):
        counted = rainflow(history, residue=rule)
        x = np.asarray(history, dtype=float)
        a, b = x[counted.from_index], x[counted.to_index]
        assert np.abs(b - a).tolist() == counted.range.tolist()
        assert (0.5 * (a + b)).tolist() == counted.mean.tolist()
        assert (b > a).tolist() == counted.rising.tolist()


def random_history(rng):
    """Noise, walks or whole numbers with ties and plateaus, 2 to 300 samples, with turning ends."""
    n = int(rng.integers(2, 300))
    kind = rng.integers(4)
    if kind == 0:
        x = rng.normal(size=n)
    elif kind == 1:
        x = np.cumsum(rng.normal(size=n))
    elif kind == 2:
        x = rng.integers(-4, 5, n).astype(float)
    else:
        x = np.round(np.cumsum(rng.normal(size=n)))
    # pyLife takes the last sample for a turning point, also at the end of a plateau
    return x[: n - int(np.argmax(x[::-1] != x[-1])) + 1] if np.ptp(x) else None


def test_pylife_counts_2000_random_histories_alike():
    detectors = pytest.importorskip("pylife.stress.rainflow")
    rng = np.random.default_rng(11)
    compared = 0
    while compared < 2000:
        x = random_history(rng)
        if x is None:
            continue
        recorder = detectors.FullRecorder()
        theirs = detectors.FourPointDetector(recorder=recorder).process(x)
        mine = rainflow(x, residue="ignore")
        assert mine.open.tolist() == theirs.residuals.tolist()
        # each with its places; pyLife takes the first sample of a plateau, too
        assert sorted(zip(mine.from_index.tolist(), mine.to_index.tolist(), strict=True)) == sorted(
            zip(recorder.index_from, recorder.index_to, strict=True)
        )
        compared += 1


def test_the_trap_of_the_residue():
    """One random walk of 200 000 samples, three rules, a factor of ten between the damages."""
    walk = np.cumsum(np.random.default_rng(0).normal(size=200_000))
    walk *= 150e6 / np.abs(walk).max()
    D = {r: damage(rainflow(walk, residue=r), CURVE) for r in ("half", "repeat", "ignore")}
    # the standard's rule in plain Python, on the turning points
    points = turning_points(walk)[0].tolist()
    half = sum(c * CURVE.damage(0.5 * r) for r, _, c in astm(points))
    assert D["half"] == pytest.approx(half, rel=1e-12)
    repeat = sum(CURVE.damage(0.5 * r) for r, _, _ in simplified(points))
    assert D["repeat"] == pytest.approx(repeat, rel=1e-12)
    assert D["half"] > 6 * D["ignore"]
    assert 1.3 * D["half"] < D["repeat"] < 2.0 * D["half"]
    # what a library without a residue rule leaves out is most of it
    assert D["repeat"] > 8 * D["ignore"]


def test_turning_points_keep_the_ends_and_drop_plateaus():
    values, index = turning_points(np.array([0.0, 0, 1, 1, 1, 0, 0, 2, 2, -1, -1]))
    assert values.tolist() == [0, 1, 0, 2, -1]
    assert index.tolist() == [0, 2, 5, 7, 9]


def test_constant_history_has_no_cycles():
    for rule in ("half", "repeat", "ignore"):
        counted = rainflow(np.full(50, 80e6), residue=rule)
        assert len(counted) == 0
        assert damage(counted, CURVE) == 0.0


def test_last_sample_closes_what_it_can():
    # 3 -> 1 lies within 0 and 5; the 5 is the end
    assert rainflow([0, 3, 1, 5], residue="ignore").sums() == {2.0: 1.0}


def test_matrix_holds_every_cycle():
    x = np.random.default_rng(0).normal(size=3000)
    cycles = rainflow(x, residue="half")
    for kind in ("range-mean", "from-to"):
        matrix = cycles.matrix(16, kind)
        assert matrix.counts.sum() == pytest.approx(cycles.total)
        assert matrix.counts.shape == (16, 16)
    # from-to: nothing on the diagonal, rising above and falling below it
    fine = rainflow([0, 4, 0, 4, 0], residue="repeat").matrix(4, "from-to")
    assert fine.counts[0, 3] + fine.counts[3, 0] == 2.0
    assert rainflow([1.0, 1.0], residue="half").matrix(4).counts.sum() == 0.0


def test_level_crossings_of_a_figure():
    # ASTM E1049-85, figure 2 method: upward crossings of a level, counted by hand on figure 6
    levels, count = rainflow(FIGURE_6, residue="half").levels(10)  # -4, -3, ... 5
    expected = {x: sum(a < x <= b for a, b in zip(FIGURE_6, FIGURE_6[1:], strict=False))
                for x in range(-4, 6)}  # fmt: skip
    assert dict(zip(levels.astype(int).tolist(), count.tolist(), strict=True)) == expected


def test_missing_rule_is_explained():
    with pytest.raises(InputError, match="factor of ten") as caught:
        rainflow(FIGURE_6)
    assert '"half"' in str(caught.value) and '"repeat"' in str(caught.value)
    with pytest.raises(InputError, match="did you mean 'half'"):
        rainflow(FIGURE_6, residue="halves")


@pytest.mark.parametrize(
    ("history", "sentence"),
    [
        ([], "is empty"),
        ([1.0], "has one sample"),
        ([0.0, np.nan, 1.0, np.inf], "sample 1 is nan \\(2 of 4"),
        ([[1.0, 2.0]], "has shape \\(1, 2\\)"),
        (["a", "b"], "not a sequence of numbers"),
    ],
)
def test_histories_that_are_none(history, sentence):
    with pytest.raises(InputError, match=sentence):
        rainflow(history, residue="half")


def test_counting_needs_no_other_package():
    code = (
        "import sys; sys.modules['pylife'] = None; import jousto as jo;"
        f"print(jo.fatigue.rainflow({FIGURE_6}, residue='half').total)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (out.returncode, out.stdout) == (0, "4.0\n"), out.stderr


def test_csv(tmp_path):
    path = rainflow(FIGURE_6, residue="half").to_csv(tmp_path / "cycles.csv")
    rows = path.read_text().splitlines()
    assert rows[0] == "range (Pa),mean (Pa),count,from,to,residue: half"
    assert len(rows) == 8
