"""What is left when Python ends."""

from __future__ import annotations

import subprocess
import sys

# a circle that only the last collection of Python finds, after the modules of jousto are gone
LATE = """
import sys
import jousto as jo
from jousto.model.native.native import Engine

body = jo.RigidBody("body", 1.0, (1.0, 1.0, 1.0))
turn = jo.Spherical("turn", jo.ground["origin"], body["origin"])

class Late: pass

late = Late()
late.itself, late.engine = late, Engine(jo.compile(jo.Mechanism(body, turn)))
sys.late = (late,)
"""


def test_an_engine_may_outlive_its_library() -> None:
    run = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
