"""Bodies of a mechanism for the engine and for results: beams, and limits of flexible bodies."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import warn
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.stiffness import BeamSection
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.inertia import principal_inertia
from jousto.mechanism.mechanism import Mechanism
from jousto.model.beam_record import BeamShape, SectionShape
from jousto.model.model import BeamModel
from jousto.model.native.header import rows

LINE = 1e-5  # ratio of principal moments of inertia below which the mass lies nearly on a line
TURN = 0.1  # rad, limit of a rotation linear in the modes: its square is 1 %
# smallest bending, relative to the length of the body, that must not rotate the frame by TURN
SMALL = 1e-3
ALIKE = 0.1  # largest variation of the rotation along the body, relative to the mean rotation


def warn_bodies(mechanism: Mechanism) -> None:
    """Warn about mean axes that rotate much more than the body bends, once per part."""
    seen: set[int] = set()
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody) and id(body.reduced) not in seen:
            seen.add(id(body.reduced))
            _warn_line(body)


def _warn_line(body: FlexibleBody) -> None:
    reduced = body.reduced
    moments, axes = principal_inertia(reduced.invariants)
    if moments[0] >= LINE * moments[-1] or reduced.rotations is None:
        return
    length = float(np.ptp(reduced.nodes @ axes[:, 0]))
    turns = np.einsum("kaj,a->kj", reduced.rotations, axes[:, 0])
    mean = turns.mean(axis=0)
    moves = np.abs(reduced.modes).max(axis=(0, 1))
    bends = np.abs(turns - mean).max(axis=0) < ALIKE * np.abs(mean)
    reach = TURN * moves[bends] / np.abs(mean[bends])
    if not len(reach) or reach.min() >= SMALL * length:
        return
    mode = int(np.flatnonzero(bends)[int(np.argmin(reach))])
    warn(
        f"body '{body.name}'",
        f"nearly all its mass lies on one line, about which it has {moments[0] / moments[-1]:.1e} "
        f"of its other inertia: bending of only {reach.min():.2g} m in mode {mode + 1} rotates "
        f"its mean axes by {TURN} rad about that line, which modes cannot represent: deflections "
        f"in one plane become too small; give the section its rotary inertia "
        f"(rotary_inertia=True), use the frame of its support node (jo.reduction.clamp(reduced, "
        f"'node1')), add point masses beside the line, or keep the "
        "modes of one plane only "
        "(reduced.keep(reduced.in_plane('xy')))",
    )


def beam_shapes(mechanism: Mechanism, index: dict[int, int]) -> tuple[BeamShape, ...]:
    """Return the data of each beam for results; `index` has the index of every body by id."""
    return tuple(_shape(beam, index) for beam in mechanism.beams)


def beam_models(mechanism: Mechanism, index: dict[int, int]) -> tuple[BeamModel, ...]:
    """Return the elements of all beams, one after the other."""
    models: list[BeamModel] = []
    for beam in mechanism.beams:
        at = [index[id(body)] for body in beam.bodies]
        models += [
            BeamModel(f"{beam.name}.element{i + 1}", beam.name, at[i], at[i + 1], data)
            for i, data in enumerate(rows("jo_beam_data", beam.n, beam.elements))
        ]
    return tuple(models)


def warn_beams(mechanism: Mechanism) -> None:
    """Warn about tension beyond the stability limit of the linear law, by weight and initial spin.

    The largest tension is the weight of a hanging beam itself, or ``m w^2 L/2`` of a beam that
    rotates about an end.
    """
    for beam in mechanism.beams:
        spin = float(beam.angular_velocity @ beam.angular_velocity)
        weight = beam.mass * float(np.linalg.norm(mechanism.gravity))
        tension = max(weight, beam.mass * spin * beam.length / 2)
        factors = beam.elements["limit"]
        worst = int(np.argmax(factors))
        if tension * factors[worst] > 1.0:
            cause = "its own weight" if tension == weight else "its spin"
            warn(
                f"beam '{beam.name}'",
                f"{cause} causes a tension of up to {tension:.3g} N, but beyond "
                f"{1 / factors[worst]:.3g} N its element {worst} is unstable: with the linear law "
                f"the section rotates in shear for N > GA/(1 - GA/EA); check E and the units, or "
                f"use GA = EA if shear is unimportant"
                + (", use more elements or leave bending=True out" if beam.bending else ""),
            )


def _shape(beam: BeamBody, index: dict[int, int]) -> BeamShape:
    kinds = {id(section): section for section in beam.sections}
    place = {key: k for k, key in enumerate(kinds)}
    return BeamShape(
        name=beam.name,
        bodies=np.array([index[id(body)] for body in beam.bodies], dtype=np.int64),
        data=rows("jo_beam_data", beam.n, beam.elements),
        s=beam.s,
        nodes=beam.nodes,
        frames=beam.frames,
        sections=tuple(_section(section) for section in kinds.values()),
        which=np.array([place[id(section)] for section in beam.sections], dtype=np.int64),
    )


def _section(section: BeamSection) -> SectionShape:
    points = section.points
    return SectionShape(
        labels=tuple(point.name for point in points),
        points=np.array([(p.y, p.z) for p in points], dtype=float).reshape(-1, 2),
        rows=np.array([p.rows for p in points], dtype=float).reshape(-1, 6, 6),
        outline=section.outline,
        elasticity=np.array(section.elasticity) if section.elasticity else None,
    )
