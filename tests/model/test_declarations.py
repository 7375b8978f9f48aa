"""The header as cffi parsed it when the engine was built, and what happens without."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from jousto.model.native import declarations as jd

HEADER = Path(jd.__file__).parents[4] / "engine" / "jousto.h"
pytestmark = pytest.mark.skipif(not HEADER.exists(), reason="an installed package")
TYPES = ("jo_model", "jo_body", "jo_joint", "jo_sensor", "jo_solver")


def test_what_was_written_is_what_the_header_says(tmp_path):
    jd.write(HEADER, tmp_path / "declared.py")
    written, parsed = jd.view(HEADER, tmp_path), jd.parsed(jd.declarations(HEADER))
    assert type(written) is not type(parsed)
    for name in TYPES:
        assert written.sizeof(name) == parsed.sizeof(name)
        fields = [(key, field.offset) for key, field in written.typeof(name).fields]
        assert fields == [(key, field.offset) for key, field in parsed.typeof(name).fields]
    assert [path.name for path in tmp_path.glob("*.py*")] == ["declared.py"]


def test_another_header_is_parsed_anew(tmp_path):
    jd.write(HEADER, tmp_path / "declared.py")
    changed = tmp_path / "jousto.h"
    text = HEADER.read_text(encoding="utf-8")
    changed.write_text(text.replace("/* END */", "typedef int jo_new;\n/* END */"), "utf-8")
    assert jd.view(changed, tmp_path).sizeof("jo_new") == 4
    assert type(jd.view(HEADER, tmp_path / "nowhere")) is type(jd.parsed("int f(void);"))


def test_a_header_that_is_parsed_anew_serves_as_well(tmp_path):
    """Without the file that the build writes, as where cffi was missing then."""
    code = (
        "from pathlib import Path; from jousto.model.native import declarations as d, library as l;"
        f"view = d.view; l.view = lambda header, _: view(header, Path({str(tmp_path)!r}));"
        "from jousto.recovery.fields.field import LANES; import jousto as jo;"
        "print(type(l.ffi()).__module__, LANES)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert found.stdout.split() == ["cffi.api", "8"], found.stderr
