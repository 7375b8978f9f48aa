"""moving_frame: run of a mechanism in natural coordinates, without the engine."""

from __future__ import annotations

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.numbers import number
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.natural.equations.gears_at_start import wind_gears
from jousto.natural.equations.initial_state import angles, declared_state, state_of_engine
from jousto.natural.equations.sensors import Reader
from jousto.natural.equations.system import Machine
from jousto.natural.equations.trapezoidal_step import PENALTY, TOLERANCE, Motion, Stepper
from jousto.natural.result import NaturalRun
from jousto.simulation.results.diagnostics import Energy
from jousto.simulation.state import State

TERMS = ("kinetic", "strain", "potential", "springs", "dissipated", "friction", "work")


@explained
def moving_frame(
    mechanism: Mechanism,
    t_end: float,
    *,
    step: float = 1e-3,
    output_step: float | None = None,
    state: State | None = None,
    penalty: float = PENALTY,
    tolerance: float = TOLERANCE,
    iterations: int = 20,
) -> NaturalRun:
    """Return the results of a run of a mechanism from 0 to `t_end` by the moving frame method.

    The unknowns of a body are ``[R, a, b, c, xi]``: origin and axes of its frame in the world, and
    modal coordinates. The constraints are enforced by an augmented Lagrangian, the integration is
    the trapezoidal rule, and velocities and accelerations are projected after every step (Altarriba
    2010, section 2.5, eq. S43-S73, after Cuadrado, Gutierrez, Naya and Gonzalez 2004). The method
    does not use the engine, so that it is an independent check.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism to simulate.
    t_end : float
        End of the run, s.
    step : float
        Step, s; shortened so that outputs and the end are at steps. Errors are of second order.
    output_step : float, optional
        Time between stored instants, s; None stores every step.
    state : State, optional
        Initial state at time 0, such as ``run.state(0.0)`` of a run of the engine; None is the
        declared state of the bodies, moved to satisfy joints and drives.
    penalty : float
        Penalty factor: alpha h^2/4 over the effective mass of a constraint. A larger one reduces
        the gap faster.
    tolerance : float
        Last increment of an axis, or of a position over the size of the mechanism, at which the
        iteration of a step has converged.
    iterations : int
        Maximum number of iterations of a step.

    Returns
    -------
    NaturalRun
        Sensors, energies, constraint residuals, iterations.

    Raises
    ------
    InputError
        With all items of the mechanism that this formulation does not support, or invalid values.
    SimulationError
        If a step does not converge.

    Examples
    --------
    >>> import jousto as jo
    >>> ball = jo.RigidBody("ball", 1.0, (1, 1, 1), position=(1, 0, 0))
    >>> rod = jo.Rod("rod", jo.ground["origin"], ball["origin"])
    >>> height = jo.PositionSensor("ball", ball["origin"])
    >>> machine = jo.Mechanism(ball, rod, jo.Gravity((0, -9.81, 0)), height, name="pendulum")
    >>> run = moving_frame(machine, 0.5, step=5e-3)
    >>> f"{run['ball'][-1, 1]:.3f} m"
    '-0.920 m'
    """
    times = {"t_end": t_end, "step": step}
    times |= {} if output_step is None else {"output_step": output_step}
    options = {"penalty": penalty, "tolerance": tolerance, "iterations": iterations}
    _check(mechanism, times, options, state)
    steps, every = _schedule(t_end, step, output_step)
    machine = Machine(mechanism)
    reader = Reader(machine, mechanism.sensors)
    machine.close()
    wind_gears(machine)
    near = angles(machine)
    q, v = declared_state(machine) if state is None else state_of_engine(machine, state)
    start = machine.place(q, 0.0, near)
    stepper = Stepper(
        machine,
        t_end / steps,
        start,
        penalty=penalty,
        tolerance=tolerance,
        most=int(iterations),
    )
    start = stepper.closed(q, 0.0, near)
    v = stepper.velocities(start, v, 0.0)
    motion = stepper.start(start, v, 0.0)
    record = Record(machine, reader, steps // every + 1)
    record.keep(motion)
    for k in range(1, steps + 1):
        motion = stepper.step(motion)
        record.work(motion)
        if k % every == 0:
            record.keep(stepper.balanced(motion))
    return record.run(mechanism.sensors)


def _check(
    mechanism: Mechanism, times: dict[str, float], options: dict[str, float], state: State | None
) -> None:
    """Raise InputError with all invalid arguments."""
    where = f"moving frame of {mechanism.name!r}"
    problems = Problems()
    for name, value in (times | options).items():
        found = number(problems, where, name, value)
        if found is not None and found <= 0.0:
            unit = " s" if name in times else ""
            problems.add(where, f"{name} is {found:g}{unit}, must be positive")
    if state is not None and state.time != 0.0:
        problems.add(where, "state must be at time 0, such as run.state(0.0)")
    if mechanism.initials and state is None:
        names = ", ".join(f"{initial.name!r}" for initial in mechanism.initials)
        problems.add(
            where,
            f"does not support Initial of {names} in its start; give the start of the engine, "
            "state=run.state(0.0) of a run by jo.simulate",
        )
    problems.raise_if_any()


def _schedule(t_end: float, step: float, output_step: float | None) -> tuple[int, int]:
    """Return the number of steps of a run, and the number between outputs."""
    outputs = 1 if output_step is None else max(1, round(t_end / output_step))
    if output_step is not None and abs(outputs * output_step - t_end) > 1e-9 * t_end:
        raise InputError(
            Problem("moving frame", f"t_end is {t_end:g} s, must be a multiple of output_step")
        )
    each = max(1, int(np.ceil(t_end / outputs / step * (1 - 1e-9))))
    return each * outputs, 1 if output_step is None else each


class Record:
    """Collector of the results of a run."""

    def __init__(self, machine: Machine, reader: Reader, count: int) -> None:
        self.machine, self.reader = machine, reader
        self.rows: list[tuple[Motion, list[Array], dict[str, float], float]] = []
        self.done = dict.fromkeys(("dissipated", "friction", "work"), 0.0)
        self.powers: dict[str, float] = {}
        self.time = 0.0

    def work(self, motion: Motion) -> None:
        """Add the work of a step by the trapezoidal rule."""
        powers = self._powers(motion)
        for key, power in powers.items():
            self.done[key] += 0.5 * (motion.t - self.time) * (power + self.powers[key])
        self.powers, self.time = powers, motion.t

    def _powers(self, motion: Motion) -> dict[str, float]:
        machine = self.machine
        rate = machine.bodies.split(motion.v)[1]
        modal = float(np.sum(machine.bodies.D * rate * rate))
        drives = -float(motion.lam @ machine.rows.driven(motion.t, 1))
        return {
            "dissipated": motion.action.damping + modal,
            "friction": motion.action.rubbed,
            "work": motion.action.work + drives,
        }

    def keep(self, motion: Motion) -> None:
        """Append the results of an instant."""
        if not self.rows:
            self.powers = self._powers(motion)
        machine = self.machine
        energies = machine.energies(motion) | self.done
        gap = np.abs(machine.velocity_gaps(motion.place, motion.v, motion.t)).max(initial=0.0)
        self.rows.append((motion, self.reader.read(motion, energies), energies, float(gap)))

    def run(self, sensors: tuple[Sensor, ...]) -> NaturalRun:
        """Return the results."""
        motions = [row[0] for row in self.rows]
        return NaturalRun(
            name=self.machine.mechanism.name,
            time=np.array([m.t for m in motions]),
            readings={
                sensor.name: np.stack([row[1][i] for row in self.rows])
                for i, sensor in enumerate(sensors)
            },
            facts={
                sensor.name: {
                    "unit": sensor.unit,
                    "resolved_in": sensor.frame,
                    "description": sensor.description,
                    "components": tuple(sensor.components),
                }
                for sensor in sensors
            },
            energy=Energy(*(np.array([row[2][term] for row in self.rows]) for term in TERMS)),
            position_residual=np.array([np.abs(m.place.C).max(initial=0.0) for m in motions]),
            velocity_residual=np.array([row[3] for row in self.rows]),
            iterations=np.array([m.iterations for m in motions], dtype=np.int64),
            q=np.stack([m.place.q for m in motions]),
            v=np.stack([m.v for m in motions]),
        )
