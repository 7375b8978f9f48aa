"""A flexible pendulum against MSC.Adams, from the finite element model to the film.

A soft beam of 2 m falls from rest about one end: T. Rantalainen, *Rakenteellisen jouston kuvaus
reaaliaikasimuloinnissa* (LUT, 2007), chapter 5. Annex 2 of the thesis prints the height of the
middle node by MSC.Adams at 101 instants of the first second, with four decimals. The comparison is
made twice: with the two modes computed here, and with the two printed in table 2.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

DATA = Path(__file__).parent / "data"
ADAMS = np.genfromtxt(DATA / "pendulum_adams.csv", delimiter=",", names=True, skip_header=1)
TABLE = np.genfromtxt(DATA / "pendulum_modes.csv", delimiter=",", names=True, skip_header=1)
FREQUENCIES = (3.5306262013, 14.6039279966)  # Hz, table 1
STEPS = (0.01, 0.001, 0.0001)  # s, of the columns of annex 2
LIMIT = 5.6e-5  # m; rounding to four decimals alone makes differences of up to 5e-5 m


def beam() -> jo.Part:
    """Five lumped masses on four soft beam elements, as in the ANSYS macro of annex 1."""
    with warnings.catch_warnings():
        # a thousandth of steel: the thesis really computes with so soft a material (its table 1
        # prints 2.08e8 Pa, the macro 2.07e8 Pa; only the latter gives the printed frequencies)
        warnings.filterwarnings("ignore", "material: E = 2.07e.08 Pa", jo.JoustoWarning)
        soft = jo.Material(E=2.07e8, nu=0.3, rho=7850)
    return jo.Part.frame(
        # the last node is a little off the line, or nothing would resist a spin about the beam
        nodes=[(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1.5, 0, 0), (2, -1e-5, 0)],
        elements=[(0, 1), (1, 2), (2, 3), (3, 4)],
        sections=jo.Rectangle(0.1, 0.1),
        materials=soft,
        theory=jo.parts.EulerBernoulli(),
        lumped=True,
        rotary_inertia=False,
        name="rod",
    )


def computed_modes(part: jo.Part) -> jo.ReducedPart:
    """Craig-Bampton about the supported node; of its modes those in the plane of the motion."""
    rod = jo.reduce(part, jo.CraigBampton(interfaces=("node1",), modes=4))
    return rod.keep(rod.in_plane("xy"))


def printed_modes(part: jo.Part) -> jo.ReducedPart:
    """The two modes as printed; of the second the x translations are illegible and negligible."""
    modes = np.zeros((5, 6, 2))
    for j in (0, 1):
        for dof, name in ((0, "x"), (1, "y"), (5, "rz")):
            modes[:, dof, j] = np.nan_to_num(TABLE[f"mode{j + 1}_{name}"])
    return jo.reduction.from_modes(part, modes.reshape(30, 2), FREQUENCIES)


def simulate(rod: jo.ReducedPart, t_end: float, step: float = 1e-3) -> jo.Solution:
    """Let the rod fall from rest about a spherical joint at node 1; step in s."""
    arm = jo.FlexibleBody("arm", rod)
    pendulum = jo.Mechanism(
        arm,
        jo.Spherical("pivot", jo.ground["origin"], arm["node1"]),
        jo.Gravity((0.0, -9.81, 0.0)),
        jo.PositionSensor("middle", arm["node3"]),
        jo.PositionSensor("tip", arm["node5"]),
        name="flexible pendulum",
    )
    return jo.simulate(jo.compile(pendulum), t_end, solver=jo.RK4(step), output_step=0.01)


def compare_steps(rod: jo.ReducedPart) -> None:
    """Print every tenth row of annex 2 with its differences, ours beside them."""
    y = ADAMS["adams_y_m"]
    table = [ADAMS["time_s"], 1e3 * y]
    for step in STEPS:
        table.append(ADAMS[f"thesis_h{step:g}_diff_um".replace(".", "")])
        table.append(1e6 * (simulate(rod, 1.0, step)["middle"][:, 1] - y))
    print("  time    Adams y " + "".join(f"{f'step {step:g} s':>19}" for step in STEPS))
    print("     s         mm " + len(STEPS) * "   thesis    jousto")
    rows = [(f"  {t:4.1f} {mm:10.1f} ", off) for t, mm, *off in np.transpose(table)[::10]]
    for head, off in (*rows, ("  largest of 101  ", np.abs(table[2:]).max(axis=1))):
        print(head + "".join(f"{x:{9 + k % 2}.1f}" for k, x in enumerate(off)))


def draw(long: jo.Solution, short: jo.Solution, path: Path) -> None:
    """The thesis' figure 13, with the difference to MSC.Adams below it."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    dots = {"markersize": 4.2, "markerfacecolor": "white", "markeredgecolor": COLORS[1]}
    with plt.style.context(STYLE):
        figure, (above, below) = plt.subplots(
            2, 1, figsize=(8, 6), height_ratios=(1.6, 1), layout="constrained"
        )
        above.plot(long.time, long["middle"][:, 1], color=COLORS[0], label="jousto, RK4, 1 ms")
        t, y = ADAMS["time_s"], ADAMS["adams_y_m"]
        above.plot(t[::4], y[::4], "o", **dots, zorder=3, label="MSC.Adams, every 4th instant")
        above.set_title("Height of the middle node", **bold)
        above.set(xlabel="time (s)", ylabel="y (m)", xlim=(0, 10))
        above.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
        below.axhspan(-50, 50, color="#EEF1F5")
        below.text(1, 55, "grey: rounding of the printed table", ha="right", color="#69707A")
        below.vlines(t, 0, 1e6 * (short["middle"][:, 1] - y), color=COLORS[0])
        below.set_title("Difference to MSC.Adams", **bold)
        below.set(xlabel="time (s)", ylabel="µm", xlim=(-0.005, 1.005), ylim=(-75, 75))
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Compare, print and draw; return 0 if every row agrees."""
    out.mkdir(parents=True, exist_ok=True)
    part = beam()
    print("Flexible pendulum against the 101 rows of MSC.Adams (Rantalainen 2007, annex 2)\n")
    print("                         f1 (Hz)       f2 (Hz)   rows within 56 µm   largest difference")
    print("  frequencies, table 1 {:.10f} {:.10f}".format(*FREQUENCIES))
    good, runs = True, []
    for name, rod in (("computed", computed_modes(part)), ("table 2", printed_modes(part))):
        runs.append(simulate(rod, 1.0))
        miss = np.abs(runs[-1]["middle"][:, 1] - ADAMS["adams_y_m"])
        within = np.sum(miss <= LIMIT)
        print("  modes: {:14}{:.10f} {:.10f} ".format(name, *rod.frequencies), end="")
        print(f"{within:9} of {len(miss)} {1e6 * miss.max():18.1f} µm")
        good &= within == len(miss) == 101
        good &= np.allclose(rod.frequencies, FREQUENCIES, rtol=2e-5)
    print("\nDifferences to MSC.Adams in µm, for three steps of integration\n")
    compare_steps(computed_modes(part))
    print("\n  Ours contain the rounding of the table, up to 50 µm; those of the thesis do not.\n")

    long = simulate(computed_modes(part), 10.0)
    files = [out / f"pendulum{end}" for end in (".png", "_still.png", ".gif")]
    draw(long, runs[0], files[0])
    jo.animate(long, files[1], stills=np.arange(0.0, 0.71, 0.07), trail="tip")
    jo.animate(long, files[2], trail="tip")
    wall, factor = (long.attributes[key] for key in ("wall_time", "real_time_factor"))
    print(f"  10 s in {wall:.3f} s, {factor:.0f} times faster than real time; ", end="")
    print(f"largest energy error {np.abs(long.energy.error).max():.1e} J, ", end="")
    print(f"gap in the joint {long.residuals.position.max():.1e} m")
    print("  written:", *files)
    print("\n  Agreement in every row." if good else "\n  NO AGREEMENT")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
