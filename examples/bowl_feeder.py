"""A part climbs the track of a bowl feeder by vibration: it sticks, slips up, slips back.

The track of 3 degrees vibrates at 50 Hz along a line 30 degrees above it, softly enough that the
part never leaves it. Where friction can carry it, the part moves with the track, else it slides:
between the changes its speed is that of a closed form, whose instants are roots. The contact finds
the same mean speed.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere
from jousto.output.style import COLORS, STYLE

G, MU, SLOPE, LINE = 9.81, 0.4, np.radians(3.0), np.radians(30.0)
RATE, AMPLITUDE = 2 * np.pi * 50.0, 0.08e-3  # rad/s, m along the line of vibration
ALONG, ACROSS = AMPLITUDE * np.cos(LINE), AMPLITUDE * np.sin(LINE)
PERIOD = 2 * np.pi / RATE


def slides(t: float, way: int) -> float:
    """Acceleration along the track of a part that slides up (1) or down (-1), m/s2."""
    press = G * np.cos(SLOPE) - ACROSS * RATE**2 * np.sin(RATE * t)
    return float(-G * np.sin(SLOPE) - way * MU * press)


def speed(t: float, t0: float, v0: float, way: int) -> float:
    """Integral of `slides` from t0, where the speed is v0, m/s."""
    steady = -G * (np.sin(SLOPE) + way * MU * np.cos(SLOPE)) * (t - t0)
    wave = -way * MU * ACROSS * RATE * (np.cos(RATE * t) - np.cos(RATE * t0))
    return float(v0 + steady + wave)


def track(t: float) -> float:
    """Speed of the track along itself, m/s."""
    return float(ALONG * RATE * np.cos(RATE * t))


def conveying(periods: int) -> float:
    """Mean speed in the last of some periods of stick and slip in closed form, m/s."""
    t, v, way, path, grid = 0.0, track(0.0), 0, 0.0, PERIOD / 400
    last = (periods - 1) * PERIOD
    while t < periods * PERIOD - 1e-12:
        t1 = min(t + grid, periods * PERIOD)
        if way == 0:  # sticks while friction can give it the acceleration of the track
            wanted = -ALONG * RATE**2 * np.sin(RATE * t1)
            way = int(wanted < slides(t1, 1)) - int(wanted > slides(t1, -1))
            v1 = track(t1)
        else:
            v1 = speed(t1, t, v, way)
            if way * (v1 - track(t1)) < 0:  # the slip ends within the step
                if way * (v - track(t)) > 0:
                    t1 = brentq(lambda s, *a: speed(s, *a) - track(s), t, t1, args=(t, v, way))
                v1, way = track(t1), 0
        path += 0.5 * (v + v1) * (t1 - t) if t >= last - 1e-12 else 0.0
        t, v = t1, v1
    return path / PERIOD


def feeder() -> jo.Model:
    """Return the track on its drive and a part on it, in axes along and across the track."""
    bowl = jo.RigidBody("bowl", 10.0, (1, 1, 1))
    part = jo.RigidBody("part", 0.02, (1e-6,) * 3, position=(0, 0, -2e-7))
    line = (np.cos(LINE), 0, np.sin(LINE))
    springs = jo.Prismatic("springs", jo.ground["origin"], bowl["origin"], axis=line)
    shake = jo.Harmonic(frequency=50.0, amplitude=AMPLITUDE, offset=springs.displacement.initial)
    drive = jo.Drive("magnet", springs.displacement, shake)
    guide = jo.ConstantOrientation("guide", jo.ground["origin"], part["origin"])
    law = PowerLaw(1e7, 1.0, restitution=0.1)  # N/m
    point = (part["origin"], Sphere(0.0))
    touch = Contact("touch", bowl["origin"], HalfSpace(), *point, law, mu_kinetic=MU)
    down = jo.Gravity((-G * np.sin(SLOPE), 0, -G * np.cos(SLOPE)))
    sensors = (
        jo.PositionSensor("part", part["origin"]),
        jo.PositionSensor("bowl", bowl["origin"]),
        jo.VelocitySensor("speed", part["origin"]),
        jo.VelocitySensor("track", bowl["origin"]),
    )
    return jo.compile(jo.Mechanism(bowl, part, springs, drive, guide, touch, down, *sensors))


def main(out: Path) -> int:
    """Compare the mean speeds and draw some periods; return 0 if they agree within 0.3 %."""
    out.mkdir(parents=True, exist_ok=True)
    run = jo.simulate(feeder(), 30 * PERIOD, solver=jo.ROS2(1e-5), output_step=PERIOD / 100)
    x = run["part"][:, 0]
    mean, exact = float((x[-1] - x[-1 - 1000]) / (10 * PERIOD)), conveying(12)
    print(f"climbs with {1e3 * mean:.3f} mm/s, closed form {1e3 * exact:.3f} mm/s")
    height = np.sin(SLOPE) * mean * 60
    print(f"in a minute it rises by {1e3 * height:.1f} mm")
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3), layout="constrained")
        left.plot(1e3 * run.time, 1e3 * x, color=COLORS[0], label="part")
        left.plot(1e3 * run.time, 1e3 * run["bowl"][:, 0], color=COLORS[1], label="track")
        left.set(xlabel="time (ms)", ylabel="along the track (mm)")
        left.legend()
        late = run.time > 27 * PERIOD
        for i, name in enumerate(("speed", "track")):
            right.plot(1e3 * run.time[late], 1e3 * run[name][late, 0], color=COLORS[i])
        right.set(xlabel="time (ms)", ylabel="speed (mm/s)")
        figure.savefig(out / "bowl_feeder.png")
        plt.close(figure)
    return int(abs(mean / exact - 1) > 3e-3 or not mean > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
