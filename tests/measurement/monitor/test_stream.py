"""Lines of numbers as loggers and broken cables write them."""

from __future__ import annotations

import io
import os
import threading

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import jousto as jo
from jousto.measurement.monitor.stream import EMPTY, NOT_A_NUMBER, PRESENT, Place, Stream


def read(text, **options):
    data = text if isinstance(text, bytes) else text.encode()
    stream = Stream(io.BytesIO(data), "data.csv", **options)
    return stream, list(stream.blocks())


def rows(blocks):
    return np.concatenate([block.time for block in blocks] or [np.zeros(0)])


def values(blocks):
    return np.concatenate([block.values for block in blocks])


def kinds(blocks):
    return [oddity.kind for block in blocks for oddity in block.oddities]


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("time,a,b\n0,1,2\n0.5,3,4\n", ("", "")),
        ("time [s],a [um/m],b [%]\n0,1,2\n0.5,3,4\n", ("um/m", "%")),
        ("time (ms); a (um/m) ;b\n0;1;2\n500;3;4\n", ("um/m", "")),
        ("Time\ta\tb\n0\t1\t2\n0.5\t3\t4\n", ("", "")),
        ("t a b\n0 1 2\n0.5   3  4\n", ("", "")),
        ("# a logger\n\ntime,a,b\ns,um/m,um/m\n0,1,2\n0.5,3,4", ("um/m", "um/m")),
        ("time,a,b\n\n# by hand\ns,um/m,um/m\n0,1,2\n0.5,3,4", ("um/m", "um/m")),
        ('\ufeff"time [s]","a","b"\r\n0,1,2\r\n0.5,3,4\r\n', ("", "")),
    ],
)
def test_headers(text, units):
    stream, blocks = read(text)
    assert stream.channels == ("a", "b")
    assert stream.header.units == units
    np.testing.assert_array_equal(rows(blocks), [0.0, 0.5])
    np.testing.assert_array_equal(values(blocks), [[1, 2], [3, 4]])
    assert kinds(blocks) == []


def test_decimal_comma():
    _, blocks = read("Zeit [s];a\n0,5;-1,25\n1,0;1e-3\n")
    np.testing.assert_array_equal(rows(blocks), [0.5, 1.0])
    np.testing.assert_array_equal(values(blocks)[:, 0], [-1.25, 1e-3])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (b"", "is empty"),
        (b"\n \n# nothing\n", "is empty"),
        (b"0,1,2\n1,2,3\n", "numbers before a header"),
        (b"\x00\xff\x13\n" * 20, "no header in the first 20 lines"),
        (b"x,y\n" * 3000, "no header in the first 1000 lines"),
    ],
)
def test_no_header(text, sentence):
    with pytest.raises(jo.InputError, match=sentence):
        read(text)


def test_cells_without_a_number():
    _, blocks = read("time,a,b,c\n0,,nan,1\n1,x,inf,2\n")
    cells = np.concatenate([block.cells for block in blocks])
    assert cells.tolist() == [[EMPTY, NOT_A_NUMBER, PRESENT], [NOT_A_NUMBER, 3, PRESENT]]
    assert np.isnan(values(blocks)[:, :2]).all()


def test_lines_without_sense_are_counted_and_told():
    stream, blocks = read("time,a\n0,1\nhello\n1,2,3\n1,2\nnan,2\n2,3\n")
    np.testing.assert_array_equal(rows(blocks), [0, 1, 2])
    assert stream.place.garbage == 3
    told = [o for block in blocks for o in block.oddities]
    assert [(o.kind, o.line) for o in told] == [("garbage", 3), ("garbage", 4), ("garbage", 6)]
    assert "'hello'" in told[0].message


def test_a_line_without_end_takes_no_memory():
    stream, blocks = read(b"time,a\n0,1\n" + b"x" * 3_000_000 + b"\n1,2\n")
    np.testing.assert_array_equal(rows(blocks), [0, 1])
    assert stream.place.garbage == 1
    assert len(stream._rest) == 0


def test_time_that_goes_backwards():
    stream, blocks = read("time,a\n0,0\n1,1\n0.5,9\n1,9\n2,2\n")
    np.testing.assert_array_equal(values(blocks)[:, 0], [0, 1, 2])
    assert stream.place.backwards == 2
    assert kinds(blocks) == ["backwards", "backwards"]


def test_a_clock_that_is_set_back_goes_on():
    text = "time,a\n" + "".join(f"{100 + k},{k}\n" for k in range(5))
    text += "".join(f"{k},{5 + k}\n" for k in range(10))
    stream, blocks = read(text)
    np.testing.assert_array_equal(values(blocks)[:, 0], np.arange(15))
    np.testing.assert_array_equal(np.diff(rows(blocks)), 1.0)
    assert kinds(blocks) == ["clock"]
    assert stream.place.clock == 1


def test_a_pause_is_told_and_a_wild_time_is_not_believed():
    text = "time,a\n0,0\n0.001,1\n1e6,9\n0.002,2\n" + "".join(
        f"{100 + 0.001 * k:.3f},{3 + k}\n" for k in range(8)
    )
    stream, blocks = read(text)
    np.testing.assert_array_equal(values(blocks)[:, 0], np.arange(11))
    assert kinds(blocks) == ["garbage", "gap"]
    assert stream.place.gaps == 1


def test_a_pipe_gives_what_has_come():
    out, into = os.pipe()
    with os.fdopen(out, "rb") as source:
        os.write(into, b"time,a\n0,1\n1,2\n2,")
        stream = Stream(source, "pipe")
        blocks = stream.blocks()
        assert next(blocks).time.tolist() == [0, 1]
        timer = threading.Timer(0.05, lambda: (os.write(into, b"3\n"), os.close(into)))
        timer.start()
        assert next(blocks).time.tolist() == [2]
        assert list(blocks) == []


GOOD = st.integers(1, 40)
JUNK = st.one_of(
    st.binary(max_size=60).map(lambda b: b.replace(b"\n", b"?")),
    st.text(max_size=40).map(lambda s: s.replace("\n", "?").encode("utf-8", "replace")),
    st.sampled_from(
        [b"", b"1,2", b"a,b,c", b"1,2,3,4", b",,", b"time,a,b", b"\x00\x00", b"--,1,2"]
    ),
)


@given(st.lists(st.tuples(GOOD, st.lists(JUNK, max_size=3)), max_size=12), st.data())
@settings(max_examples=60, deadline=None)
def test_whatever_comes_good_lines_are_read(pieces, data):
    """Every good line is read in its order; only junk that reads as a line of numbers may add."""
    text, expected, k = b"time,a,b\n", [], 0
    for number, junk in pieces:
        for _ in range(number):
            text += b"%d,%d,%d\n" % (k, 2 * k, 3 * k)
            expected.append(k)
            k += 1
        for line in junk:
            try:  # a line that happens to be numbers is no junk
                cells = [float(c) for c in line.decode("utf-8", "replace").split(",")]
                line = b"?" if len(cells) == 3 else line
            except ValueError:
                pass
            text += line + b"\n"
    _, blocks = read(text)
    found = rows(blocks)
    assert found.tolist() == expected
    assert np.all(np.diff(found) > 0)


@given(st.binary(max_size=400))
@settings(max_examples=150, deadline=None)
def test_any_bytes_are_survived(junk):
    _, blocks = read(b"time,a,b\n" + junk)
    assert np.all(np.diff(rows(blocks)) > 0)


def test_reading_goes_on_from_any_block():
    text = "time,a\n" + "".join(f"{k},{k}\n{'junk' if k % 7 == 0 else ''}\n" for k in range(3000))
    data = text.encode()
    stream, whole = read(text)
    for stop in (1, 4):
        first = Stream(io.BytesIO(data), "data.csv")
        blocks = first.blocks()
        before = [next(blocks) for _ in range(stop)]
        place = Place.from_numbers(first.place.numbers())
        again = Stream(io.BytesIO(data), "data.csv")
        again.continue_at(place)
        after = list(again.blocks())
        for a, b in zip(whole, before + after, strict=True):
            np.testing.assert_array_equal(a.time, b.time)
        assert again.place == stream.place


@pytest.mark.parametrize("cut", ["time,a\n", "time,a\nms", "time,a\n\n# made by hand\n"])
def test_a_unit_row_that_comes_later_than_its_header(cut):
    text = "time,a\n\n# made by hand\nms,um/m\n" if "#" in cut else "time,a\nms,um/m\n"
    out, into = os.pipe()
    with os.fdopen(out, "rb") as source:
        os.write(into, cut.encode())
        stream = Stream(source, "pipe")
        assert stream.channels == ("a",)
        os.write(into, (text[len(cut) :] + "0,1\n500,2\nms,um/m\n").encode())
        os.close(into)
        blocks = list(stream.blocks())
    assert stream.header.units == ("um/m",)
    np.testing.assert_array_equal(rows(blocks), [0.0, 0.5])
    # a second one is garbage
    assert kinds(blocks) == ["garbage"]


def test_a_unit_row_behind_a_long_preamble_of_a_file():
    """The header ends a piece that is read at once, the units begin the next."""
    from jousto.measurement.monitor.stream import PIECE

    head = "time,a\n"
    text = "#" + "x" * (PIECE - len(head) - 2) + "\n" + head + "s,um/m\n0,1\n"
    stream, blocks = read(text)
    assert stream.header.units == ("um/m",)
    assert kinds(blocks) == []
