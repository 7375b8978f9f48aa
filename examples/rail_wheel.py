"""Fatigue of a rail conveyor wheel: parts, mechanism, motion, stress, life, and a better wheel.

The conveyor of ``rail_wheel.yaml`` runs over bad joints of its rail and through a curve; that gives
the forces of a wheel, a disc of solids that turns under them: every revolution is a cycle of its
web, and the curve bends the web to and fro. Critical planes (Findley), counted by rainflow, tell
its life, Hertz's stress below the rolling contact that of the tread. A web half as thick again
lasts many times longer.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import jousto as jo
from jousto.output.style import COLORS, STYLE

Array = NDArray[np.float64]
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0, name="steel")
WEB = jo.SN(S_D=210e6, N_D=2e6, k=6.0, name="forged steel").with_factors(0.6)  # as forged
TREAD = jo.SN(S_D=480e6, N_D=5e6, k=9.0, name="hardened tread")
WEIGHT, SPEED, T_END = 14e3 * 9.81, 1.2, 7.0  # N, m/s, s
RADIUS, WIDTH, SECTORS, LAYERS = 0.10, 0.03, 16, 2  # of the wheel, m
RINGS = np.array([0.022, 0.031, 0.040, 0.047, 0.054, 0.062, 0.070, 0.078, 0.088, RADIUS])  # m
# nodes of an element in half steps along radius, axis and circumference
LOCAL = "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 001 201 221 021"


def wheel(web: float) -> jo.Part:
    """The wheel, axis y: hub, web of that thickness (m) with smooth fillets, rim."""
    i, j, k = np.indices((2 * len(RINGS) - 1, 2 * LAYERS + 1, 2 * SECTORS))
    keep = (i % 2) + (j % 2) + (k % 2) <= 1  # no nodes amid faces or elements
    number = np.where(keep, np.cumsum(keep).reshape(keep.shape) - 1, -1)
    r = np.interp(i[keep] / 2, np.arange(len(RINGS)), RINGS)
    u, v = np.clip([(0.054 - r) / 0.02, (r - 0.07) / 0.016], 0, 1)
    hub, rim = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    thickness = web + (0.05 - web) * hub + (WIDTH - web) * rim
    y, angle = 0.5 * thickness * (j[keep] / LAYERS - 1), np.pi * k[keep] / SECTORS
    nodes = np.stack([r * np.cos(angle), y, r * np.sin(angle)], axis=1)
    first = 2 * np.indices((len(RINGS) - 1, LAYERS, SECTORS)).reshape(3, -1).T
    at = first[:, None] + [[int(step) for step in node] for node in LOCAL.split()]
    number = number[at[..., 0], at[..., 1], at[..., 2] % (2 * SECTORS)]
    cells = jo.mesh.Cells("hexahedron20", number)
    bore = jo.Interface("bore", np.flatnonzero(np.isclose(r, RINGS[0])))
    return jo.Part.solid(jo.Mesh("wheel", nodes, (cells,)), STEEL, interfaces=(bore,))


def tread_loads(part: jo.Part) -> Array:
    """Nodal forces (sectors, ndof, 2): 1 N inwards and 1 N sideways on a sector of the tread."""
    x, _, z = part.nodes.T
    loads = []
    for middle in 2 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS:
        off = np.angle(np.exp(1j * (np.arctan2(z, x) - middle)))
        on = np.isclose(np.hypot(x, z), RADIUS) & (np.abs(off) < 1.01 * np.pi / SECTORS)
        ways = ((-np.cos(middle), 0.0, -np.sin(middle)), (0.0, 1.0, 0.0))
        f = [part.load(jo.parts.Traction(np.flatnonzero(on), way)) for way in ways]
        loads.append([g / np.linalg.norm(g.reshape(-1, 3).sum(axis=0)) for g in f])
    return np.swapaxes(loads, 1, 2)


def roll(web: float, time: Array, forces: Array) -> tuple[jo.Solution, jo.ReducedPart]:
    """The wheel turns on its axle; forces (nt, 2) downwards and sideways go round its tread."""
    part = wheel(web)
    loads = tread_loads(part)
    reduced = jo.reduce(part, jo.CraigBampton(("bore",), modes=6, residuals=tuple(loads)))
    body = jo.FlexibleBody("wheel", reduced, damping=0.02)
    axle = jo.Revolute("axle", jo.ground["origin"], body["bore"], axis=(0, 1, 0))
    turn = jo.Ramp(0.0, T_END, 0.0, T_END * SPEED / RADIUS)
    elements = [body, axle, jo.Drive("rolling", axle.angle, turn), jo.ReactionSensor("axle", axle)]
    pitch = 2 * np.pi / SECTORS
    for sector in range(SECTORS):
        # what touches the rail is 90 degrees behind the angle turned; neighbours share the force
        off = np.angle(np.exp(1j * (turn(time) - np.pi / 2 - (sector + 0.5) * pitch)))
        share = np.maximum(1.0 - np.abs(off) / pitch, 0.0)
        for way in range(2):
            pattern = np.zeros_like(reduced.nodes)
            pattern[: len(part.nodes)] = loads[sector, :, way].reshape(-1, 3)
            signal = jo.Table(time, share * forces[:, way])
            name = f"tread {sector} {way}"
            elements.append(jo.mechanism.ModalLoad(name, body, pattern, signal=signal))
    with warnings.catch_warnings():
        # the wheel's own vibration, above 2 kHz, is damped away by the step: it lives of statics
        warnings.simplefilter("ignore", jo.JoustoWarning)
        model = jo.compile(jo.Mechanism(*elements))
        return jo.simulate(model, T_END, solver=jo.ROS2(step=1e-3), output_step=4e-3), reduced


def draw(
    t: Array, forces: Array, webs: dict[str, Array], tread: jo.fatigue.RollingLife, path: Path
) -> None:
    """Forces of the wheel, stress in the web, and the stress below the tread."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(3, 1, figsize=(7.2, 7.0), layout="constrained")
        for color, series, name in zip(COLORS, forces.T, ("down", "sideways"), strict=False):
            axes[0].plot(t, 1e-3 * series, color=color, label=name)
        for color, (web, stress) in zip(COLORS, webs.items(), strict=False):
            axes[1].plot(t, 1e-6 * stress, color=color, label=web)
        axes[2].plot(1e3 * tread.depth, 100 * tread.utilisation, "o-", color=COLORS[0])
        axes[0].set(ylabel="kN", title="Forces of the front left wheel")
        axes[1].set(xlabel="s", ylabel="MPa", title="Radial stress at the worst place of the web")
        axes[2].set(xlabel="mm below the tread", ylabel="% of the limit", title="Rolling contact")
        for ax in axes[:2]:
            ax.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run the chain for two wheels; return 0 if the laws hold."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(Path(__file__).with_suffix(".yaml"))
    model = jo.compile(file.mechanism)
    run = jo.simulate(model, T_END, **file.simulation.given(model))
    t, forces = run.time, np.column_stack([run["front left"], run["guide front"]])
    sides = [f"{end} {side}" for end in ("front", "rear") for side in ("left", "right")]
    good = abs(sum(float(np.ravel(run[name])[0]) for name in sides) / WEIGHT - 1) < 1e-6
    lives, webs = [], {}
    for web in (0.006, 0.009):
        rolled, reduced = roll(web, t, forces)
        axle = np.linalg.norm(rolled["axle"][50:, :3], axis=1)
        good &= np.abs(axle / np.hypot(*forces[50:].T) - 1).max() < 0.02  # carries the rail's force
        field = jo.stress_field(rolled, "wheel", reduced=reduced)
        r = np.hypot(*field.positions[:, ::2].T)
        places = np.flatnonzero((r > 0.045) & (r < 0.08))
        field = field.take(places[np.argsort(-field.envelope("von-mises").max[places])[:2]])
        rule = jo.fatigue.Findley(0.25)
        found = jo.fatigue.plane_damage(field, rule, WEB, residue="repeat", step=15.0)
        x, _, z = field.positions[0] / np.hypot(*field.positions[0, ::2])
        radial = field.history(field.labels[0]) @ [x * x, 0, z * z, 0, 0, 2 * x * z]
        webs[f"web of {1e3 * web:g} mm"] = radial
        lives.append(found.life.min())
        print(f"web of {1e3 * web:g} mm, {reduced!r}", found, sep="\n")
    contact = jo.fatigue.hertz_line(forces[:, 0].max(), length=WIDTH, radius=RADIUS, material=STEEL)
    passes = np.interp(np.arange(0, T_END, 2 * np.pi * RADIUS / SPEED), t, forces[:, 0])
    tread = jo.fatigue.rolling_life(contact, passes, jo.fatigue.Findley(0.25), TREAD, friction=0.05)
    limit = jo.fatigue.shakedown_limit(0.05) * 700e6 / 3**0.5
    print(contact, tread, f"shakedown: {100 * contact.p0 / limit:.0f} % of the limit", sep="\n")
    draw(t, forces, webs, tread, out / "rail_wheel.png")
    good &= lives[1] > 3 * lives[0] and contact.p0 < limit
    print("laws hold" if good else "A LAW DOES NOT HOLD")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
