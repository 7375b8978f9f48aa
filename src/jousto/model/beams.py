"""Beams of a mechanism for the engine and for results."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import warn
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.stiffness import BeamSection
from jousto.mechanism.mechanism import Mechanism
from jousto.model.beam_record import BeamShape, SectionShape
from jousto.model.model import BeamModel
from jousto.model.native.header import rows


def beam_shapes(mechanism: Mechanism, index: dict[int, int]) -> tuple[BeamShape, ...]:
    """Return what results keep of each beam; `index` holds the place of every body by its id."""
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
    """Warn of tension that the linear law does not bear, from weight and initial spin.

    A beam bears at most its own weight where it hangs, and ``m w^2 L/2`` where it turns about an
    end.
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
                f"{cause} pulls with up to {tension:.3g} N, but beyond {1 / factors[worst]:.3g} N "
                f"its element {worst} is unstable: the linear law lets the section turn aside in "
                "shear, N > GA/(1 - GA/EA); check E and the units, give it GA = EA where shear "
                "does not matter"
                + (", take more elements or leave bending=True out" if beam.bending else ""),
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
