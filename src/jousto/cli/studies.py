"""Commands that analyse a model: equilibrium, modes, linearise, kinematics."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.base.files import written
from jousto.cli.group import command
from jousto.cli.options import (
    Initial,
    Model,
    Output,
    Trust,
    amount,
    compile_model,
    compiled_model,
    end_time,
)
from jousto.cli.terminal import facts, most_at, named, numbers, plain, say

MATRICES = (".npz", ".mat")

FREE = 1e-6  # 1/s, below which a rate is round-off


@command()
def equilibrium(model: Model, trust: Trust = False) -> None:
    """Find where a model rests: positions of the bodies and values of the sensors."""
    from jousto.model.native.native import Engine
    from jousto.simulation.statics.equilibrium import equilibrium as rest

    compiled = compiled_model(model, trust)
    state = rest(compiled)
    engine = Engine(compiled)
    engine.q[:], engine.v[:], engine.time[0] = state.q, state.v, state.time
    engine.accelerations()
    values = engine.sensors()
    # of beams the ends
    inner = {int(i) for beam in compiled.beam_shapes for i in beam.bodies[1:-1]}
    rows = [
        (f"body {body.name}", f"origin at x y z = {numbers(state.q[body.iq : body.iq + 3])} m")
        for i, body in enumerate(compiled.bodies)
        if i not in inner
    ]
    for sensor in compiled.sensors:
        found = values[sensor.offset : sensor.offset + sensor.count]
        rows.append((f"sensor {sensor.name}", named(found, sensor.components, sensor.unit)))
    facts(rows, f"{model.name} at rest")


@command()
def modes(
    model: Model,
    count: Annotated[
        int, typer.Option("--count", "-n", min=1, help="How many, the slowest first.")
    ] = 10,
    initial: Initial = False,
    trust: Trust = False,
) -> None:
    """Compute the natural modes of a model, without damping, about where it rests."""
    from jousto.simulation.modes.linear import modes as natural
    from jousto.simulation.statics.equilibrium import equilibrium as rest

    compiled = compiled_model(model, trust)
    found = natural(compiled, None if initial else rest(compiled))
    rows = []
    for k, value in enumerate(found.eigenvalues[:count]):
        text = f"{found.frequencies[k]:.6g} Hz"
        if value.real > abs(value.imag):
            text = f"falls away, {value.real:.6g} 1/s"
        if abs(value) < FREE:
            text = "free motion, 0 Hz"
        moves = most_at({name: shapes[k] for name, shapes in found.shapes.items()})
        rows.append((f"mode {k + 1}", f"{text}, most at {moves}"))
    place = "its initial pose" if initial else "rest"
    facts(rows or [("modes", "none: nothing is free to move")], f"{model.name} about {place}")


@command()
def linearise(
    model: Model,
    output: Output = None,
    initial: Initial = False,
    trust: Trust = False,
) -> None:
    """Linearise a model: A, B, C, D of its inputs and sensors, into MODEL.npz or -o FILE.mat."""
    import numpy as np

    from jousto.schema.targets import output_path
    from jousto.simulation.modes.linear import linearise as small_motions
    from jousto.simulation.statics.equilibrium import equilibrium as rest

    target = output_path(output, model, ".npz")
    if target.suffix not in MATRICES:
        raise InputError(Problem(str(target), f"must end with {' or '.join(MATRICES)}"))
    compiled = compiled_model(model, trust)
    found = small_motions(compiled, None if initial else rest(compiled))
    values: dict[str, Any] = {
        "A": found.A,
        "B": found.B,
        "C": found.C,
        "D": found.D,
        "inputs": np.array(found.input_names, dtype=str),
        "outputs": np.array(found.output_names, dtype=str),
    }
    with written(target) as beside:
        if target.suffix == ".mat":
            from scipy.io import savemat

            names = ("inputs", "outputs")
            savemat(beside, values | {name: values[name].astype(object) for name in names})
        else:
            np.savez(beside, **values)
    rows = [
        ("states", str(len(found.A))),
        ("inputs", ", ".join(found.input_names) or "none"),
        ("outputs", ", ".join(found.output_names) or "none"),
    ]
    facts(rows, f"{model.name} about {'its initial pose' if initial else 'rest'}")
    say(f"A, B, C, D in {target}", style="green")


@command()
def kinematics(
    model: Model,
    output: Output = None,
    t_end: Annotated[
        str | None, typer.Option("--t-end", metavar="TIME", help="Last instant such as 2 or '5 s'.")
    ] = None,
    instants: Annotated[
        int, typer.Option("--instants", "-n", min=1, help="How many instants, evenly spaced.")
    ] = 101,
    trust: Trust = False,
) -> None:
    """Move a fully driven model without integration, with the forces of its drives."""
    import numpy as np

    from jousto.schema.file.read import read_model
    from jousto.schema.targets import RESULTS, output_path
    from jousto.simulation.kinematics import kinematics as motion

    target = output_path(output, model, ".h5", kind=RESULTS)
    file = read_model(model, trust=trust)
    end = amount(t_end, "s", "--t-end") or end_time(file, model, "until when")
    found = motion(compile_model(file.mechanism), np.linspace(0.0, end, instants), path=target)
    rows = [
        ("instants", str(len(found.time))),
        ("last instant (s)", plain(float(found.time[-1]))),
        ("largest position residual", plain(float(found.residuals.position.max(initial=0.0)))),
    ]
    facts(rows)
    say(f"results in {target}", style="green")
