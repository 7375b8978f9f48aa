"""Cost of the damage meter: one history, many side by side, and inside the engine.

Prints nanoseconds per sample. A random walk with few reversals, noise with one at two samples of
three, and a sine are counted; pyLife counts the same histories, all at once, where it is installed.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

import jousto as jo

STEEL = jo.SN(S_D=100e6, N_D=1e6, k=5)


def best(call, repeats=3):
    """Shortest wall time of a few calls, s."""
    spent = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        spent.append(time.perf_counter() - start)
    return min(spent)


def histories(n: int) -> dict[str, np.ndarray]:
    """Stress histories (n,), Pa."""
    rng = np.random.default_rng(1)
    return {
        "random walk": np.cumsum(rng.normal(size=n)) * 1e6,
        "noise": rng.normal(size=n) * 50e6,
        "sine, 100 samples a period": 100e6 * np.sin(0.02 * np.pi * np.arange(n)),
    }


def single(n: int = 1_000_000) -> None:
    """One meter, and pyLife."""
    print(f"one history of {n} samples, ns per sample")
    for name, x in histories(n).items():
        meter = jo.model.DamageMeter(STEEL, residue="half")
        spent = best(lambda m=meter, x=x: m.push(x), 3)
        print(f"  {name:<28} {1e9 * spent / n:7.2f}", end="")
        try:
            import pylife.stress.rainflow as RF
        except ImportError:
            print()
            continue
        whole = best(lambda x=x: RF.FourPointDetector(RF.LoopValueRecorder()).process(x), 1)
        print(f"   pyLife, cycles alone {1e9 * whole / n:7.2f}")


def one_by_one(n: int = 20_000) -> None:
    """A sample at a time from Python, as a monitor gets them."""
    meter = jo.model.DamageMeter(STEEL, residue="half")
    x = histories(n)["noise"]

    def push() -> None:
        for value in x:
            meter.push([value])

    print(f"one sample a call from Python {1e9 * best(push, 1) / n:.0f} ns")


def many(n: int = 100_000, nt: int = 200) -> None:
    """A field of stress, block by block."""
    rng = np.random.default_rng(2)
    meter = jo.model.DamageMeter(STEEL, residue="half", n=n, depth=32)
    for name, x in (
        ("noise", rng.normal(size=(nt, n)) * 50e6),
        ("one sine, scaled", np.outer(np.sin(0.1 * np.arange(nt)), rng.uniform(0, 1e8, n))),
    ):
        spent = best(lambda x=x: meter.push(x), 2)
        rate = x.nbytes / spent / 1e9
        print(f"{n} histories x {nt} samples, {name:<18} {1e9 * spent / x.size:7.2f} ns per sample")
        print(f"  that is {rate:.2f} GB/s of samples")
    print(f"reading the damage of all {1e9 * best(meter.damage, 1) / n:.0f} ns each")


def in_engine(steps: int = 20_000) -> None:
    """What a damage sensor adds to a step."""
    part = jo.Part.beam(
        length=1.0,
        section=jo.Rectangle(0.02, 0.025),
        elements=8,
        material=jo.Material(E=2e11, nu=0.3, rho=7850),
    )
    rod = jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=6))
    arm = jo.FlexibleBody("arm", rod)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], (0, 1, 0))
    stress = jo.StressSensor("stress", arm, "e1.a.top")
    life = jo.mechanism.DamageSensor(
        "life", stress, STEEL, residue="half", components="e1.a.top:s11"
    )
    spent = []
    for more in ((), (life,)):
        model = jo.compile(jo.Mechanism(arm, pin, jo.Gravity((0, 0, -9.81)), stress, *more))
        engine = jo.model.Engine(model)
        solver = engine.native_solver("ros2", 1e-4, True)
        rows = np.zeros((steps // 1000 + 1, engine.row_size))
        spent.append(best(lambda e=engine, s=solver, r=rows: e.run(s, steps, 1000, r)))
    plain, metered = (1e9 * x / steps for x in spent)
    print(f"a step of the engine {plain:.0f} ns, with a damage sensor {metered:.0f} ns")


PROGRAM = """
#include "jousto.h"
#include <math.h>
#include <stdlib.h>
int main(int n, char **a)
{
    static double memory[JO_METER + 64];
    jo_meter r = {0};
    unsigned seed = 1;
    r.depth = 64; r.amplitude = 1e8; r.cycles = 1e6; r.slope = r.below = 5.0;
    for (int i = 0; i < 100000; i++) {
        seed = seed * 1664525u + 1013904223u;
        double x = n > 1 && atoi(a[1]) ? 1e8 * sin(0.0628 * i) : (seed >> 8) * 10.0;
        if (n > 2) jo_meter_push(&r, memory, &x, 1);
        else memory[0] += x;
    }
    return memory[5] < 0.0;
}
"""


def instructions() -> None:
    """Instructions per sample, which repeat exactly on any machine: needs cc and valgrind."""
    if not (shutil.which("cc") and shutil.which("valgrind")):
        print("no cc or valgrind: instructions are not counted")
        return
    engine = Path(__file__).parents[1] / "engine"
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "count.c", Path(folder) / "count"
        source.write_text(PROGRAM, encoding="utf-8")
        build = [
            "cc",
            "-O3",
            "-std=c99",
            f"-I{engine}",
            source,
            engine / "fatigue" / "damage_meter.c",
            "-o",
            program,
        ]
        subprocess.run([*build, "-lm"], check=True)

        def count(*given: str) -> int:
            tool = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out"]
            done = subprocess.run([*tool, program, *given], capture_output=True, text=True)
            return int(done.stderr.split("Collected :")[1].split()[0])

        for name, kind in (("noise", "0"), ("sine, 100 samples a period", "1")):
            bare = count(kind) if kind == "1" else count()
            print(f"{name:<28} {(count(kind, 'count') - bare) / 1e5:.0f} instructions per sample")


if __name__ == "__main__":
    instructions()
    single()
    one_by_one()
    many()
    in_engine()
