"""Measured records: what loggers write is read, and what is wrong with it is told."""

from __future__ import annotations

import warnings

import h5py
import numpy as np
import pytest

import jousto as jo

T = np.arange(0.0, 2.0, 0.01)
G1 = 250e-6 * np.sin(2 * np.pi * 1.3 * T)
FORCE = 1e3 * np.cos(2 * np.pi * 0.7 * T)


def written(tmp_path, text, name="data.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path


def rows(separator, number, unit_t=1.0):
    return "\n".join(
        separator.join(number(x) for x in row)
        for row in zip(T * unit_t, G1 * 1e6, FORCE / 1e3, strict=True)
    )


def point(x):
    return f"{x:.9g}"


def comma(x):
    return f"{x:.9g}".replace(".", ",")


FORMS = {
    "plain": ("time [s],g1 [um/m],force [kN]\n", ",", point, 1.0, "utf-8"),
    "german": (
        "Messung 12; Prüfstand 3\nKanäle: 3\n\nZeit;g1;force\n[s];[µm/m];[kN]\n",
        ";", comma, 1.0, "cp1252",
    ),
    "finnish": ("Aika (ms)\tg1 (µm/m)\tforce (kN)\n", "\t", comma, 1e3, "utf-16"),
    "blanks": ("# t[s] g1[ustrain] force[kN]\n", "  ", point, 1.0, "utf-8"),
    "units below": ("Time,g1,force\ns,um/m,kN\n", ",", point, 1.0, "utf-8-sig"),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_tables_of_many_loggers(tmp_path, form):
    head, separator, number, factor, encoding = FORMS[form]
    path = written(tmp_path, head + rows(separator, number, factor) + "\n", encoding=encoding)
    record = jo.gauges.read_record(path)
    assert list(record.channels) == ["g1", "force"]
    assert dict(record.units) == {"g1": "m/m", "force": "N"}
    np.testing.assert_allclose(record.time, T, atol=1e-9)
    np.testing.assert_allclose(record["g1"], G1, atol=1e-12)
    np.testing.assert_allclose(record["force"], FORCE, atol=1e-5)
    assert record.notes == ()
    assert record.uniform
    assert "g1" in str(record)


def test_a_delimiter_at_the_end_and_missing_values(tmp_path):
    text = "time;g1 [um/m];\n0;1,5;\n0,1;;\n0,2;NaN;\n0,3;2,5;\nSTOP\n0,4;2,0;\n"
    with pytest.warns(jo.JoustoWarning) as caught:
        record = jo.gauges.read_record(written(tmp_path, text))
    assert list(record.channels) == ["g1"]
    np.testing.assert_allclose(record["g1"], [1.5e-6, np.nan, np.nan, 2.5e-6, 2e-6])
    sentences = [str(w.message).partition(": ")[2] for w in caught]
    assert sentences == [
        "1 lines are not 3 numbers and were left out (line 6)",
        "channel 'g1' misses 2 of 5 values, first at 0.1 s",
    ]
    assert list(record.notes) == sentences


def test_dates_and_times_of_day(tmp_path):
    text = "date,g1 [um/m]\n2024-05-01 12:00:00.000,1\n2024-05-01 12:00:00.500,2\n"
    text += "2024-05-01 12:00:01.000,4\n"
    record = jo.gauges.read_record(written(tmp_path, text))
    np.testing.assert_allclose(record.time, [0, 0.5, 1.0], atol=1e-6)
    german = "Zeit;g1\n1.5.2024 12:00:00,0;1,0\n1.5.2024 12:00:00,5;2,0\n"
    np.testing.assert_allclose(
        jo.gauges.read_record(written(tmp_path, german)).time, [0, 0.5], atol=1e-6
    )


def test_files_without_time(tmp_path):
    path = written(tmp_path, "g1 [um/m],g2 [um/m]\n5,1\n3,4\n4,0\n")
    with pytest.raises(jo.InputError, match="no column of time: none of g1, g2 is called time"):
        jo.gauges.read_record(path)
    record = jo.gauges.read_record(path, rate=200.0)
    np.testing.assert_allclose(record.time, [0, 0.005, 0.01])
    assert list(record.channels) == ["g1", "g2"]


def test_everything_wrong_at_once(tmp_path):
    """Time backwards and twice, an unknown unit, percent for strain: one error names them all."""
    text = (
        "time [s],g1 [m/m],g2 [furlong],g3 [m/m]\n"
        "0,0.02,1,100\n0.1,0.03,2,300\n0.1,0.01,3,200\n0.05,0.04,1,100\n0.3,0.02,4,50\n"
    )
    path = written(tmp_path, text)
    with pytest.raises(jo.InputError) as error:
        jo.gauges.read_record(path)
    found = [str(p).removeprefix(f"{path}: ") for p in error.value.problems]
    assert found == [
        "channel 'g1' reaches 0.04: too large for strain in m/m, it was likely given in %; give "
        "units={'g1': '%'} (the file says 'm/m')",
        "channel 'g2' has the unknown unit 'furlong'; give units={'g2': ...} with one such as "
        "um/m, mV/V, MPa, kN or 1",
        "channel 'g3' reaches 300: too large for strain in m/m, it was likely given in um/m; give "
        "units={'g3': 'um/m'} (the file says 'm/m')",
        "time runs backwards 1 times, first from 0.1 s to 0.05 s at sample 3; repair=True sorts "
        "the samples",
        "1 instants come twice, first 0.1 s at sample 2; repair=True keeps the first of each",
    ]
    units = {"g1": "%", "g2": "1", "g3": "um/m"}
    with pytest.warns(jo.JoustoWarning, match=r"sorted|kept|gap"):
        record = jo.gauges.read_record(path, units=units, repair=True)
    np.testing.assert_allclose(record.time, [0, 0.05, 0.1, 0.3])
    np.testing.assert_allclose(record["g1"], [2e-4, 4e-4, 3e-4, 2e-4])
    np.testing.assert_allclose(record["g3"], [1e-4, 1e-4, 3e-4, 5e-5])


def blocks(offset):
    return "".join(f"{(i % 10) * 0.1 + offset * (i // 10):.3f},{i}\n" for i in range(30))


@pytest.mark.parametrize("offset", [0.0, 0.003])
@pytest.mark.parametrize("repair", [False, True])
def test_a_clock_that_restarts_is_refused(tmp_path, offset, repair):
    """Three records of 10 samples in one file are not one of 10, nor one jagged one of 30."""
    path = written(tmp_path, "time [s],g1 [um/m]\n" + blocks(offset))
    with pytest.raises(jo.InputError, match=r"the clock restarts: 3 blocks.*sample 10 \(0.9 to"):
        jo.gauges.read_record(path, repair=repair)


def test_packets_in_the_wrong_order_are_sorted(tmp_path):
    """They fill gaps; a late sample and retries are no restart, and what is dropped is counted."""
    order = [*range(10), *range(20, 30), *range(10, 20), *range(30, 40), 5, 40, 41, 5]
    text = "time [s],g1 [um/m]\n" + "".join(f"{i / 10},{i}\n" for i in order)
    with pytest.warns(jo.JoustoWarning, match=r"sorted|dropped"):
        record = jo.gauges.read_record(written(tmp_path, text), repair=True)
    assert record.notes[-1].endswith("2 of 44 samples dropped")
    np.testing.assert_allclose(record["g1"], 1e-6 * np.arange(42))


def test_midnight(tmp_path):
    text = "time,g1 [um/m]\n23:59:59.8,4\n23:59:59.9,5\n00:00:00.0,6\n00:00:00.1,7\n"
    path = written(tmp_path, text)
    with pytest.raises(jo.InputError, match="over midnight 1 times.* counts on from there"):
        jo.gauges.read_record(path)
    with pytest.warns(jo.JoustoWarning, match="a day was added"):
        record = jo.gauges.read_record(path, repair=True)
    np.testing.assert_allclose(record.time - record.time[0], [0, 0.1, 0.2, 0.3], atol=1e-9)


def test_quoted_decimal_commas(tmp_path):
    text = 'time [s],"g1 [um/m]"\n"0,0","1,5"\n"0,1","2,5"\n"0,2",3\n'
    record = jo.gauges.read_record(written(tmp_path, text))
    assert list(record.channels) == ["g1"]
    np.testing.assert_allclose(record.time, [0, 0.1, 0.2])
    np.testing.assert_allclose(record["g1"], [1.5e-6, 2.5e-6, 3e-6])


@pytest.mark.parametrize("row", ["0,00,1,50", "0,1,50"])
def test_more_numbers_than_names(tmp_path, row):
    """Decimal commas between commas cannot be told apart."""
    path = written(tmp_path, f"time [s],g1 [um/m]\n{row}\n1{row[1:]}\n")
    with pytest.raises(jo.InputError, match=r"line 1 names 2 columns .* line 2 has \d numbers"):
        jo.gauges.read_record(path)


@pytest.mark.parametrize(("text", "sentence"), [
    ("", "is empty: there is no line of numbers"),
    ("  \n\n", "is empty: there is no line of numbers"),
    ("hello world\nfoo bar\n", "has no table of numbers"),
    ("time,g1\n0,1\n", "has 1 instants, must have two or more"),
    ("time [kg],g1\n0,1\n1,2\n", "time is in 'kg', must be s, ms, us, min or h"),
])  # fmt: skip
def test_files_of_no_use(tmp_path, text, sentence):
    with pytest.raises(jo.InputError, match=sentence):
        jo.gauges.read_record(written(tmp_path, text))


def test_places_that_are_not_there(tmp_path):
    path = written(tmp_path, "time,g1\n0,1\n1,2\n")
    with pytest.raises(jo.InputError, match="there is no such file; did you mean 'data.csv'"):
        jo.gauges.read_record(tmp_path / "dat.csv")
    with pytest.raises(jo.InputError, match="no column 'tim'; did you mean 'time'"):
        jo.gauges.read_record(path, time="tim")
    with pytest.raises(jo.InputError, match="units: no channel 'g2'"):
        jo.gauges.read_record(path, units={"g2": "um/m"})
    record = jo.gauges.read_record(path)
    with pytest.raises(jo.InputError, match="no channel 'g2'"):
        record["g2"]
    with pytest.raises(jo.InputError, match="was likely given in um/m"):
        jo.gauges.Record(T, {"g1": 1e6 * G1}).strains()
    with pytest.raises(jo.InputError, match="channel 'f' is in N, must be strain"):
        jo.gauges.Record(T, {"f": FORCE}, {"f": "N"}).strains(["f"])


def test_gaps_dead_and_saturated_channels(tmp_path):
    keep = (T < 0.8) | (T > 1.0)
    clipped = np.clip(G1, -150e-6, 150e-6)
    dead = np.zeros(len(T))
    rest = 1e-4 * np.clip(T / 1.5, 0, 1) ** 2 * (3 - 2 * np.clip(T / 1.5, 0, 1))  # comes to rest
    record = jo.gauges.Record(
        T[keep], {"g1": clipped[keep], "g2": dead[keep], "g3": rest[keep], "g4": G1[keep]},
        dict.fromkeys(("g1", "g2", "g3", "g4"), "m/m"),
    )  # fmt: skip
    path = record.to_csv(tmp_path / "gaps.csv")
    with pytest.warns(jo.JoustoWarning):
        notes = jo.gauges.read_record(path).notes
    assert len(notes) == 4
    assert notes[0].startswith("1 gaps in time, the longest of 0.22 s after 0.79 s (usually 0.01")
    high, low = (int(np.count_nonzero(clipped[keep] == s * 150e-6)) for s in (1, -1))
    assert notes[1].startswith(f"channel 'g1' is cut off at its upper end 0.00015 for {high} sam")
    assert notes[2].startswith(f"channel 'g1' is cut off at its lower end -0.00015 for {low} sam")
    assert notes[3] == "channel 'g2' is constant (0): dead or not connected"


def test_csv_comes_back(tmp_path):
    x = G1.copy()
    x[5] = np.nan
    record = jo.gauges.Record(T, {"g1": x, "f": FORCE}, {"g1": "m/m", "f": "N"})
    with pytest.warns(jo.JoustoWarning, match="misses 1 of 200"):
        back = jo.gauges.read_record(record.to_csv(tmp_path / "r.csv"))
    np.testing.assert_array_equal(back.time, T)
    np.testing.assert_array_equal(back["g1"], x)
    assert dict(back.units) == dict(record.units)


# pyuff leaves the files open that it has written
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_universal_files(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    for binary in (0, 1):
        path = tmp_path / f"data{binary}.uff"
        uff = pyuff.UFF(str(path))
        for name, x, label in (("g1", 1e6 * G1, "um/m"), ("NONE", FORCE, "N")):
            data = pyuff.prepare_58(
                binary=binary, id1=name, func_type=1, ver_num=1, load_case_id=1,
                rsp_ent_name="NONE", rsp_node=7, rsp_dir=3, ref_ent_name="NONE", ref_node=0,
                ref_dir=0, data=x, x=T, ord_data_type=4, abscissa_spacing=1, abscissa_min=0.0,
                abscissa_inc=0.01, num_pts=len(T), abscissa_spec_data_type=17,
                ordinate_spec_data_type=0, orddenom_spec_data_type=0, z_axis_spec_data_type=0,
                ordinate_axis_units_lab=label, abscissa_axis_units_lab="s",
            )  # fmt: skip
            uff.write_sets(data, mode="add")
        record = jo.gauges.read_record(path)
        assert list(record.channels) == ["g1", "7:+3"]
        np.testing.assert_allclose(record.time, T, atol=1e-6)
        np.testing.assert_allclose(record["g1"], G1, atol=1e-9)
        assert dict(record.units) == {"g1": "m/m", "7:+3": "N"}


def test_hdf5_files(tmp_path):
    path = tmp_path / "data.h5"
    with h5py.File(path, "w") as file:
        file["run/time"] = T
        file["run/g1"] = 1e6 * G1
        file["run/g1"].attrs["unit"] = "um/m"
        file["run/short"] = T[:5]
    with pytest.warns(jo.JoustoWarning, match="'short' has 5 values, time 200: left out"):
        record = jo.gauges.read_record(path)
    np.testing.assert_allclose(record["g1"], G1)
    # results of a run: its sensors
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], ball["origin"], (0, 0, 1))
    sensor = jo.PositionSensor("ball", ball["origin"])
    model = jo.compile(jo.Mechanism(ball, slide, jo.Gravity((0, 0, -9.81)), sensor))
    jo.simulate(model, 0.1, output_step=0.01, path=tmp_path / "run.h5")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        record = jo.gauges.read_record(tmp_path / "run.h5")
    assert list(record.channels) == ["ball.x", "ball.y", "ball.z"]
    assert record.units["ball.z"] == "m"
    np.testing.assert_allclose(record["ball.z"], -9.81 / 2 * record.time**2, atol=1e-6)


# -- resampling -------------------------------------------------------------------------------


def test_resampling():
    record = jo.gauges.Record(T, {"g1": G1}, {"g1": "m/m"})
    fine = record.resample(1000.0)
    inside = fine.time < 1.9
    true = 250e-6 * np.sin(2 * np.pi * 1.3 * fine.time)
    np.testing.assert_allclose(fine["g1"][inside], true[inside], atol=1e-9)
    # uneven instants are no trouble
    uneven = np.sort(np.random.default_rng(3).uniform(0, 2, 400))
    scattered = jo.gauges.Record(uneven, {"g1": np.interp(uneven, T, G1)}, {"g1": "m/m"})
    even = scattered.resample(100.0, gap=50.0)
    assert even.uniform
    ok = np.isfinite(even["g1"])
    assert np.abs(even["g1"] - 250e-6 * np.sin(2 * np.pi * 1.3 * even.time))[ok].max() < 5e-6
    assert np.isnan(record.resample(times=[-1.0, 0.5, 3.0])["g1"]).tolist() == [True, False, True]


def test_resampling_does_not_fold_frequencies():
    """40 Hz at 50 samples per second would look like 10 Hz; the filter takes it out."""
    t = np.arange(0, 4, 0.001)
    record = jo.gauges.Record(t, {"x": np.sin(2 * np.pi * 2 * t) + np.sin(2 * np.pi * 40 * t)})
    coarse = record.resample(50.0)
    middle = (coarse.time > 0.5) & (coarse.time < 3.5)
    wanted = np.sin(2 * np.pi * 2 * coarse.time)
    assert np.abs(coarse["x"] - wanted)[middle].max() < 0.01
    folded = record.resample(50.0, antialias=False)
    assert np.abs(folded["x"] - wanted)[middle].max() > 0.5


def test_gaps_stay_unknown():
    keep = (T < 0.8) | (T > 1.0)
    record = jo.gauges.Record(T[keep], {"g1": G1[keep]})
    even = record.resample(100.0)
    lost = np.isnan(even["g1"])
    assert lost[(even.time > 0.81) & (even.time < 0.99)].all()
    assert not lost[(even.time < 0.79) | (even.time > 1.02)].any()
    for bad, sentence in (
        ({"rate": -1.0}, "rate is -1"),
        ({"rate": 1.0, "times": [1.0]}, "give rate or times, not both"),
        ({"times": [1.0, 0.5]}, "times do not ascend"),
    ):
        with pytest.raises(jo.InputError, match=sentence):
            record.resample(**bad)


def test_cutting_and_zeroing():
    record = jo.gauges.Record(T, {"g1": G1 + 5e-6, "g2": G1}, {"g1": "m/m"})
    assert record.during(0.5, 1.0).time[[0, -1]] == pytest.approx([0.5, 1.0])
    with pytest.raises(jo.InputError, match="nothing from 5 to inf s; it goes from 0 to 1.99 s"):
        record.during(5.0)
    rest = jo.gauges.Record(T, {"g1": 5e-6 + np.where(T < 0.5, 0.0, G1)}).zeroed(0.0, 0.49)
    assert abs(rest["g1"][:40]).max() < 1e-18
    assert list(record.renamed({"g1": "top"}).channels) == ["top", "g2"]
    assert list(record.only(["g2"]).channels) == ["g2"]
    assert record.shifted(1.0).time[0] == 1.0
    with pytest.raises(jo.InputError) as error:
        jo.gauges.Record([0, 1, 1], {"a": [1, 2]}, {"b": "m"})
    assert len(error.value.problems) == 3
