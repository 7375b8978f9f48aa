"""Joint friction: a closed form and a motion located event by event, in plain NumPy and SciPy.

A block on a belt sticks and slips (closed form); a point mass on a rod swings on a pin with Coulomb
friction, whose normal force contains the acceleration. Neither uses the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81


@dataclass(frozen=True)
class Belt:
    """A block held by a spring to the ground on a belt that moves at constant speed.

    It sticks until the spring pulls with mu_s m g, then slips under mu_k m g: with
    D = (mu_s - mu_k) m g / k and w = sqrt(k/m) the slip is a harmonic motion about mu_k m g / k
    from the stretch D and the speed v of the belt, until the speed is v again.
    """

    mass: float = 1.0
    stiffness: float = 100.0
    static: float = 0.4
    kinetic: float = 0.2
    speed: float = 0.1

    @property
    def stretch(self) -> float:
        """D, m."""
        return (self.static - self.kinetic) * self.mass * GRAVITY / self.stiffness

    @property
    def frequency(self) -> float:
        """w, rad/s."""
        return float(np.sqrt(self.stiffness / self.mass))

    @property
    def stick_time(self) -> float:
        """From slip's end to slip's start: the stretch goes from -D to D, s."""
        return 2 * self.stretch / self.speed

    @property
    def slip_time(self) -> float:
        """2/w (pi - atan(D w / v)), s."""
        return 2 / self.frequency * (np.pi - np.arctan(self.stretch * self.frequency / self.speed))

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest position of the block against the relaxed spring, m."""
        middle = self.kinetic * self.mass * GRAVITY / self.stiffness
        reach = float(np.hypot(self.stretch, self.speed / self.frequency))
        return middle - reach, middle + reach


@dataclass(frozen=True)
class PinPendulum:
    """A point mass m at distance l from a pin of radius r with Coulomb friction mu.

    ``m l^2 w' = -m g l sin th - mu r N sgn(w)``,
    ``N^2 = (m l w^2 + m g cos th)^2 + (m l w' + m g sin th)^2``. The friction arm r N mu is
    m l^2 w' + m g l sin th = l (m l w' + m g sin th) =: l T, so that T = mu r N / l and
    ``T = c R / sqrt(1 - c^2)`` with R = m l w^2 + m g cos th (absolute), c = mu r / l.
    """

    mass: float = 1.0
    length: float = 1.0
    radius: float = 0.05
    friction: float = 0.3

    def acceleration(self, th: float, w: float, way: float) -> float:
        """w' while the pin slips in the direction `way` (+1 or -1)."""
        c = self.friction * self.radius / self.length
        along = self.mass * (self.length * w**2 + GRAVITY * np.cos(th))
        T = c * abs(along) / np.sqrt(1 - c**2)
        return float(-GRAVITY / self.length * np.sin(th) - way * T / (self.mass * self.length))

    def sticks(self, th: float) -> bool:
        """Whether the pin holds the weight at rest: |tan th| within c / sqrt(1 - c^2)."""
        c = self.friction * self.radius / self.length
        return bool(abs(np.sin(th)) <= c)

    def turning_points(self, th: float, count: int) -> list[tuple[float, float]]:
        """Times, s, and angles, rad, at rest, from rest at `th`; ends where the pin sticks."""
        found: list[tuple[float, float]] = []
        t = 0.0
        while len(found) < count and not self.sticks(th):
            way = -np.sign(np.sin(th))

            def rest(_: float, y: np.ndarray, way: float = way) -> float:
                return float(way * y[1])

            rest.terminal, rest.direction = True, -1  # type: ignore[attr-defined]
            run = solve_ivp(
                lambda _, y, way=way: [y[1], self.acceleration(y[0], y[1], way)],
                (t, t + 10.0),
                [th, way * 1e-300],
                method="DOP853",
                rtol=1e-13,
                atol=1e-15,
                events=rest,
            )
            t, th = float(run.t_events[0][0]), float(run.y_events[0][0][0])
            found.append((t, th))
        return found
