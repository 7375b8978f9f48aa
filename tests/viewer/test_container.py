"""The container in which scenes and numbers travel."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from jousto.base.errors import InputError
from jousto.viewer.container import TYPES, pack, unpack

KINDS = sorted(TYPES)


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_of_all_types_come_back(kind: str) -> None:
    array = np.array([[0, 1, 2], [3, 200, 5]]).astype(TYPES[kind])
    found = unpack(pack({"a": array, "deeper": [{"b": array[0]}]}))
    for given, back in ((array, found["a"]), (array[0], found["deeper"][0]["b"])):
        assert back.dtype == given.dtype
        np.testing.assert_array_equal(back, given)


def test_layout_is_that_of_the_contract() -> None:
    data = pack({"name": "Rückzug", "a": np.array([1.5], "f4"), "b": np.array([7], ">u2")})
    length = int.from_bytes(data[4:8], "little")
    assert data[:4] == b"JOV1" and (8 + length) % 8 == 0
    header = json.loads(data[8 : 8 + length])
    assert header == {
        "name": "Rückzug",
        "a": {"at": 0, "shape": [1], "type": "f4"},
        "b": {"at": 8, "shape": [1], "type": "u2"},
    }
    payload = data[8 + length :]
    assert payload[:4] == np.array([1.5], "<f4").tobytes() and payload[8:10] == b"\x07\x00"


def test_what_json_lacks_becomes_null_and_other_numbers_fit() -> None:
    found = unpack(
        pack({"x": float("nan"), "y": np.float64(2.5), "i": np.arange(3), "b": np.array([True])})
    )
    assert found["x"] is None and found["y"] == 2.5
    assert found["i"].dtype == np.int32 and found["b"].dtype == np.uint8


def test_one_array_in_two_places_is_written_once() -> None:
    array = np.zeros(10_000)
    assert len(pack({"a": array, "b": array})) < 1.1 * array.nbytes


def test_empty_arrays_and_columns_of_others() -> None:
    block = np.arange(12.0).reshape(3, 4)
    found = unpack(pack({"none": np.zeros((0, 3)), "column": block[:, 1], "turned": block.T}))
    assert found["none"].shape == (0, 3)
    np.testing.assert_array_equal(found["column"], [1, 5, 9])
    np.testing.assert_array_equal(found["turned"], block.T)


def test_large_whole_numbers_and_objects_are_refused() -> None:
    with pytest.raises(InputError, match="32 bits"):
        pack({"a": np.array([2**40])})
    with pytest.raises(InputError, match="does not accept arrays of object"):
        pack({"a": np.array([None])})


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda data: b"PNG" + data, "does not begin with a header"),
        (lambda data: data[:6], "does not begin with a header"),
        (lambda data: data[:20], "does not begin with a header"),
        (lambda data: data[:-8], "ends within an array"),
        (lambda data: data.replace(b'"at"', b'"at '), "damaged header"),
    ],
)
def test_damage_is_named(spoil: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        unpack(spoil(pack({"a": np.arange(4.0)})))  # type: ignore[operator]


def test_the_page_reads_the_same_types() -> None:
    text = (Path(__file__).parents[2] / "frontend" / "src" / "protocol.ts").read_text("utf-8")
    line = next(line for line in text.splitlines() if line.startswith("const SIZES"))
    assert all(f"{name}: {kind.itemsize}" in line for name, kind in TYPES.items())
