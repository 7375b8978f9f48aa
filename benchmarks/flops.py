"""Exact operation counts of the engine, and what this processor could do.

The engine's sources are compiled once more as C++ with a scalar that counts: nothing is estimated.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any
from unittest import mock

import cffi
import numpy as np

import jousto as jo
from jousto.export import sources
from jousto.model.native import library
from jousto.model.native.declarations import declarations
from jousto.simulation.solvers.base import prepared

ENGINE = Path(__file__).parent.parent / "engine"

COUNTING_SCALAR = """
#pragma once
#include <math.h>
extern "C" { extern long long jo_flops; }
struct jo_real {
    double x;
    jo_real() = default;
    jo_real(double v) : x(v) {}
    explicit operator double() const { return x; }
    jo_real &operator+=(jo_real b) { jo_flops++; x += b.x; return *this; }
    jo_real &operator-=(jo_real b) { jo_flops++; x -= b.x; return *this; }
    jo_real &operator*=(jo_real b) { jo_flops++; x *= b.x; return *this; }
    jo_real &operator/=(jo_real b) { jo_flops++; x /= b.x; return *this; }
};
#define JO_OP(op) \\
    static inline jo_real operator op(jo_real a, jo_real b) { jo_flops++; return a.x op b.x; } \\
    static inline jo_real operator op(jo_real a, double b) { jo_flops++; return a.x op b; } \\
    static inline jo_real operator op(double a, jo_real b) { jo_flops++; return a op b.x; } \\
    static inline jo_real operator op(jo_real a, int b) { jo_flops++; return a.x op b; } \\
    static inline jo_real operator op(int a, jo_real b) { jo_flops++; return a op b.x; }
JO_OP(+) JO_OP(-) JO_OP(*) JO_OP(/)
static inline jo_real operator-(jo_real a) { return -a.x; }
static inline bool operator==(jo_real a, jo_real b) { return a.x == b.x; }
static inline bool operator!=(jo_real a, jo_real b) { return a.x != b.x; }
static inline jo_real sqrt(jo_real a) { jo_flops++; return sqrt(a.x); }
static inline jo_real exp(jo_real a) { jo_flops++; return exp(a.x); }
static inline jo_real pow(jo_real a, jo_real b) { jo_flops++; return pow(a.x, b.x); }
static inline jo_real log(jo_real a) { jo_flops++; return log(a.x); }
static inline jo_real atan(jo_real a) { jo_flops++; return atan(a.x); }
static inline jo_real tanh(jo_real a) { jo_flops++; return tanh(a.x); }
static inline jo_real sin(jo_real a) { jo_flops++; return sin(a.x); }
static inline jo_real cos(jo_real a) { jo_flops++; return cos(a.x); }
static inline jo_real atan2(jo_real a, jo_real b) { jo_flops++; return atan2(a.x, b.x); }
"""

PEAK = """
/* ten independent chains of scalar fused multiply-adds hide their latency: 20 operations a turn;
 * they start from different numbers, or a compiler would keep one of them */
double peak(long long turns, double a, double b)
{
    double x0 = a, x1 = a + 1, x2 = a + 2, x3 = a + 3, x4 = a + 4;
    double x5 = a + 5, x6 = a + 6, x7 = a + 7, x8 = a + 8, x9 = a + 9;
    for (long long i = 0; i < turns; i++) {
        x0 = x0 * a + b; x1 = x1 * a + b; x2 = x2 * a + b; x3 = x3 * a + b; x4 = x4 * a + b;
        x5 = x5 * a + b; x6 = x6 * a + b; x7 = x7 * a + b; x8 = x8 * a + b; x9 = x9 * a + b;
    }
    return x0 + x1 + x2 + x3 + x4 + x5 + x6 + x7 + x8 + x9;
}
"""


def scalar_peak() -> float:
    """Scalar fused multiply-add rate of one core, 1e9 operations per second (an FMA is two)."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "peak.c"
        source.write_text(PEAK)
        target = Path(folder) / "peak.so"
        flags = ["-O2", "-march=native", "-ffp-contract=fast", "-fno-tree-vectorize"]
        flags += ["-fno-tree-slp-vectorize", "-shared", "-fPIC"]
        subprocess.run(["cc", *flags, str(source), "-o", str(target)], check=True)
        ffi = cffi.FFI()
        ffi.cdef("double peak(long long turns, double a, double b);")
        lib = ffi.dlopen(str(target))
        turns, best = 10_000_000, np.inf
        for _ in range(5):
            begin = time.process_time()
            lib.peak(turns, 0.999, 0.001)
            best = min(best, time.process_time() - begin)
        ffi.dlclose(lib)
    return 20.0 * turns / best / 1e9


class Counter:
    """Counts the operations of one step of any model."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        (folder / "counting.h").write_text(COUNTING_SCALAR)
        for name, text in {**sources.headers(), **sources.engine()}.items():
            if name == "jousto.h":
                text = text.replace("typedef double jo_real;", '#include "counting.h"', 1)
                text = re.sub(r"/\* BEGIN \*/", 'extern "C" {', text)
                text = re.sub(r"/\* END \*/", "}", text)
            text = text.replace("#define JO_RE(x) (x)", "#define JO_RE(x) ((double)(x))")
            text = re.sub(
                r"#(el)?if defined\(__GNUC__\) && !defined\(JO_COMPLEX\).*", r"#\1if 0", text
            )
            (folder / re.sub(r"\.c$", ".cpp", name)).write_text(text)
        (folder / "count.cpp").write_text('extern "C" { long long jo_flops = 0; }\n')
        target = folder / "counting.so"
        files = [str(path) for path in folder.glob("*.cpp")]
        flags = ["-O0", "-w", "-fpermissive", "-Drestrict=__restrict__", "-shared", "-fPIC"]
        built = subprocess.run(
            ["c++", *flags, *files, "-o", str(target), "-lm"], capture_output=True, text=True
        )
        if built.returncode:
            raise RuntimeError("the engine does not count: " + built.stderr[:1000])
        ffi = cffi.FFI()
        ffi.cdef("extern long long jo_flops;" + declarations(ENGINE / "jousto.h"))
        self._ffi, self._library = ffi, ffi.dlopen(str(target))

    def per_step(self, model: jo.Model, solver: Any) -> float:
        """Additions, subtractions, multiplications, divisions and roots of one step."""
        with (
            mock.patch.object(library, "real_library", lambda: self._library),
            mock.patch.object(library, "ffi", lambda: self._ffi),
        ):
            engine = jo.model.Engine(model)
            native = engine.native_solver(solver.method, 1e-4, solver.projection)
            rows = np.zeros((1, engine.row_size))
            engine.run(native, 5, 10**9, rows)
            before = self._library.jo_flops
            engine.run(native, 20, 10**9, rows)
            return float(self._library.jo_flops - before) / 20.0

    def each_step(self, model: jo.Model, solver: Any, steps: int) -> np.ndarray:
        """The same operations of each of the first steps (steps,), without rows of results."""
        with (
            mock.patch.object(library, "real_library", lambda: self._library),
            mock.patch.object(library, "ffi", lambda: self._ffi),
        ):
            engine = jo.model.Engine(model)
            native = prepared(engine, solver, solver.step)
            rows, found = np.zeros((1, engine.row_size)), np.zeros(steps)
            for i in range(steps):
                before = self._library.jo_flops
                status, _ = engine.run(native, 1, 10**9, rows)
                assert status == "ok", status
                found[i] = self._library.jo_flops - before
            return found
