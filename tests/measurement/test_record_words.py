"""Words of measured records that change numbers: each is done, refused or told."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.measurement.gauges.read import read_record
from jousto.measurement.gauges.units import parse_unit


def write(tmp_path: Path, text: str, name: str = "record.csv") -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


def rows(*columns: np.ndarray, delimiter: str = ";") -> str:
    return "".join(
        delimiter.join(f"{x:.9g}" for x in row) + "\n" for row in zip(*columns, strict=True)
    )


T = 0.01 * np.arange(100)
X = 5.0 + np.sin(30.0 * T)


@pytest.mark.parametrize(
    ("label", "si", "factor"),
    [
        # NIST SP 811 (2008), appendix B
        ("lbf", "N", 4.4482216152605),
        ("kp", "N", 9.80665),
        ("psi", "Pa", 6894.757),
        ("in", "m", 0.0254),
        ("A", "A", 1.0),
        ("U/min", "rad/s", 2.0 * np.pi / 60.0),
    ],
)
def test_a_line_of_units(label: str, si: str, factor: float, tmp_path: Path) -> None:
    text = f"time;load;g1\ns;{label};um/m\n" + rows(T, X, X)
    record = read_record(write(tmp_path, text))
    assert record.units == {"load": si, "g1": "m/m"}
    # the label of the table has seven digits
    np.testing.assert_allclose(record["load"], factor * X, rtol=1e-7)
    np.testing.assert_allclose(record["g1"], 1e-6 * X, rtol=1e-8)


def test_a_unit_that_nobody_knows_is_told_and_stays_one(tmp_path: Path) -> None:
    text = "time;load;g1\ns;furlong;um/m\n" + rows(T, X, X)
    with pytest.raises(InputError, match="channel 'load' has the unknown unit 'furlong'"):
        read_record(write(tmp_path, text))
    record = read_record(tmp_path / "record.csv", units={"load": "kN"})
    np.testing.assert_allclose(record["g1"], 1e-6 * X, rtol=1e-8)
    np.testing.assert_allclose(record["load"], 1e3 * X, rtol=1e-8)


def test_lines_with_fewer_fields_at_the_end_are_told(tmp_path: Path) -> None:
    text = "time;a;b\n" + rows(T[:50], X[:50], X[:50]) + rows(T[50:], X[50:])
    with pytest.warns(jo.JoustoWarning, match=r"50 lines are not 3 numbers .* \(line 52, 53, 54"):
        record = read_record(write(tmp_path, text))
    assert len(record.time) == 50


@pytest.mark.parametrize(
    ("head", "first", "unit", "what"),
    [
        ("timestamp", 1.7e12, 1e-3, "milliseconds since 1970"),
        ("t", 1.7e15, 1e-6, "microseconds since 1970"),
        ("time", 45000.25, 86400.0, "days of a spreadsheet"),
        ("date", 738000.25, 86400.0, "days of MATLAB"),
    ],
)
def test_other_clocks(head: str, first: float, unit: float, what: str, tmp_path: Path) -> None:
    stamps = "".join(f"{first + t / unit:.12f};{x:.9g}\n" for t, x in zip(60 * T, X, strict=True))
    with pytest.warns(jo.JoustoWarning, match=f"column '{head}' counts {what}"):
        record = read_record(write(tmp_path, f"{head};a\n{stamps}"))
    # microseconds have a quarter of a millisecond as a float, days 10 microseconds
    np.testing.assert_allclose(record.time, 60 * T, atol=3e-4)


def test_seconds_that_look_like_days(tmp_path: Path) -> None:
    path = write(tmp_path, "time;a\n" + "".join(f"{45000 + t:.6f};{t}\n" for t in 1e-4 * T))
    record = read_record(path, units={"time": "s"})
    np.testing.assert_allclose(record.time, 45000.0 + 1e-4 * T, atol=1e-6)
    # steps of a second are no days
    slow = write(tmp_path, "time;a\n" + "".join(f"{45000 + k};{k % 7}\n" for k in range(50)))
    np.testing.assert_allclose(read_record(slow).time, 45000.0 + np.arange(50))


def test_a_clock_of_any_name_is_seconds_if_that_is_said(tmp_path: Path) -> None:
    stamps = 1.7e12 + 10.0 * np.arange(50)
    path = write(tmp_path, "clock;a\n" + "".join(f"{t:.0f};{t % 7}\n" for t in stamps))
    with pytest.warns(jo.JoustoWarning, match=r"give units=\{'clock': 's'\} if it is seconds"):
        read_record(path, time="clock")
    record = read_record(path, time="clock", units={"clock": "s"})
    np.testing.assert_array_equal(record.time, 10.0 * np.arange(50))
    with h5py.File(tmp_path / "record.h5", "w") as file:
        file["time"], file["a"] = stamps, stamps % 7.0
    record = read_record(tmp_path / "record.h5", units={"time": "s"})
    np.testing.assert_array_equal(record.time, 10.0 * np.arange(50))


@pytest.mark.parametrize("head", ["frequency;a", "f [Hz];a", "way [mm];a", "Freq;a"])
def test_a_spectrum_is_no_record(head: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no column of time: the first, '\w+', is"):
        read_record(write(tmp_path, f"{head}\n" + rows(100 * T, X)))


LVM = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t{point}
Multi_Headings\tNo
X_Columns\t{columns}
Time_Pref\tRelative
Date\t2026/05/01
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t100\t100\t
Date\t2026/05/01\t2026/05/01\t
Y_Unit_Label\tum/m\tkN\t
X_Dimension\t{over}\t{over}\t
X0\t0.5\t0.5\t
Delta_X\t0.010000\t0.010000\t
***End_of_Header***\t\t\t
"""


@pytest.mark.parametrize("columns", ["One", "No", "Multi"])
@pytest.mark.parametrize("point", [".", ","])
def test_labview(columns: str, point: str, tmp_path: Path) -> None:
    # the specification of National Instruments: the column of X is there, and blank for "No"
    heads = {"One": "X_Value\tgauge\tload", "Multi": "X_Value\tgauge\tX_Value\tload"}
    text = LVM.format(point=point, columns=columns, over="Time")
    text += heads.get(columns, heads["One"]) + "\tComment\n"
    for t, x in zip(T + 0.5, X, strict=True):
        at = "" if columns == "No" else f"{t:.6f}"
        second = f"{at}\t{2 * x:.9g}" if columns == "Multi" else f"{2 * x:.9g}"
        text += f"{at}\t{x:.9g}\t{second}\n".replace(".", point)
    record = read_record(write(tmp_path, text, "record.lvm"))
    assert record.units == {"gauge": "m/m", "load": "N"}
    np.testing.assert_allclose(record.time, T + 0.5, atol=1e-9)
    np.testing.assert_allclose(record["gauge"], 1e-6 * X, rtol=1e-8)
    np.testing.assert_allclose(record["load"], 2e3 * X, rtol=1e-8)


def test_labview_files_that_are_refused(tmp_path: Path) -> None:
    text = LVM.format(point=".", columns="One", over="Frequency") + "X_Value\ta\tb\n1\t2\t3\n"
    for content, sentence in (
        (text, "runs over Frequency, not over time"),
        (text[: text.index("Channels")], "header is cut off"),
        (text.replace("Frequency", "Time").replace("1\t2\t3", "1\t2\tx"), "must be 3 numbers"),
        (text.replace("Frequency", "Time").replace("1\t2\t3\n", ""), "no line of numbers"),
        (
            LVM.format(point=".", columns="No", over="Time").replace("Delta_X", "Delta")
            + "X_Value\ta\tb\n\t2\t3\n",
            "Delta_X is '', must be a number",
        ),
    ):
        with pytest.raises(InputError, match=sentence):
            read_record(write(tmp_path, content, "record.lvm"))


# pyuff leaves the files open that it has written
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize(("announced", "held"), [(100, 60), (60, 100)])
def test_universal_files_hold_what_they_announce(announced: int, held: int, tmp_path: Path) -> None:
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "record.uff"
    function = pyuff.prepare_58(
        binary=0, id1="a", func_type=1, ver_num=1, load_case_id=1, rsp_ent_name="NONE", rsp_node=7,
        rsp_dir=3, ref_ent_name="NONE", ref_node=0, ref_dir=0, data=X[:held], x=T[:held],
        ord_data_type=4, abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=0.01, num_pts=held,
        abscissa_spec_data_type=17, ordinate_spec_data_type=0, orddenom_spec_data_type=0,
        z_axis_spec_data_type=0, ordinate_axis_units_lab="MPa", abscissa_axis_units_lab="s",
    )  # fmt: skip
    pyuff.UFF(str(path)).write_sets(function, mode="add")
    text = path.read_text()
    assert f"{held:10d}" in text
    path.write_text(text.replace(f"{held:10d}", f"{announced:10d}", 1))
    if held < announced:
        with pytest.raises(InputError, match="announces 100 points but has 60: it is cut off"):
            read_record(path)
        return
    record = read_record(path)
    assert len(record.time) == announced
    np.testing.assert_allclose(record["a"], 1e6 * X[:announced], rtol=1e-5)


def test_units_are_those_of_the_tables() -> None:
    assert parse_unit("kip") == ("N", pytest.approx(4448.222))
    assert parse_unit("ksi") == ("Pa", pytest.approx(6894757.0))
