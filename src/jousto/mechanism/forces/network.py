"""Law of the engine of first-order states, see `jousto.mechanism.states.block`."""

from jousto.mechanism.forces.law import EngineLaw

EngineLaw(
    "network",
    constants=(
        *("number", "states", "coordinates", "signals", "constants"),
        *("values", "instructions", "pushes", "slopes", "memories", "gravity", "openings"),
    ),
    between=True,
    fast={"states": ()},
).declared()
EngineLaw(
    "memory",
    constants=(
        *("network", "first", "count", "period", "phase", "margin", "jumps"),
        *("jitter", "seed"),
    ),
    yields=True,
).declared()
EngineLaw(
    "delay",
    constants=("network", "input", "slope", "time", "points", "given", "initial", "size"),
    yields=True,
).declared()
