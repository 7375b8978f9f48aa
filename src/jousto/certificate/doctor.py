"""doctor: mobility of a mechanism, and redundant or contradictory joints."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import skew
from jousto.base.errors import InputError, JoustoWarning, Problem, count, warn
from jousto.base.garbage_collection import uncollected
from jousto.base.object_repr import described
from jousto.base.rotations import rotation_matrix
from jousto.certificate.load_warnings import unheld_loads
from jousto.mechanism.mechanism import Mechanism
from jousto.model.compile import compile
from jousto.model.gear_springs import explicit_step
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.overlaps import overlaps
from jousto.model.rank.motions import moving, neighbour, without_drives
from jousto.model.rank.redundancy import (
    RANK,
    Redundancy,
    constraint_matrix,
    is_drive,
    repeated_rows,
    unit_rows,
)
from jousto.model.tree import BODIES, core_of

RK4_STABLE = 2.785293563  # largest step times rate at which RK4 is stable
FEW = 3  # largest number of states that are listed
SHOWN = 5  # largest number of overlaps that are listed
LARGE = 2000  # number of velocities above which the mobility with rigid bodies is not computed


class Run(Protocol):
    """Interface of the results of a run."""

    @property
    def name(self) -> str:
        """Name of the mechanism."""

    @property
    def contacts(self) -> Any:
        """Contacts of the run, with `findings`."""

    @property
    def attributes(self) -> Any:
        """Attributes of the run by name."""


@described
@dataclass(frozen=True)
class Diagnosis:
    """Findings of `doctor`, for printing.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    rows : int
        Constraint rows of joints, couplings and drives.
    mobility : int or None
        Number of free motions, modal coordinates included; None if the mechanism cannot be
        assembled.
    rigid_mobility : int or None
        Number of free motions with rigid bodies; None if unknown.
    moving, driven, still : tuple of str
        Bodies that can move freely, that move by drives only, and that cannot move, at the initial
        and at neighbouring poses.
    dead : tuple of str
        Bodies that cannot move at the initial pose (a dead centre) but can at neighbouring poses.
    redundancy : Redundancy or None
        Redundant rows.
    problems : tuple of Problem
        Reasons why the mechanism cannot be assembled; empty if it can.
    warnings : tuple of str
        Further warnings.
    core : str
        Solver core, and the reason if it is not joint coordinates (see `compile`).
    explicit_step : float or None
        Step, s, below which RK4 is stable with the gear springs (`ElasticJoint`) and the springs,
        dampers and servos along their shafts; None without any.
    fastest : tuple of (str, float)
        Fastest pressures of hydraulic networks with the bounds of their rates, 1/s.
    overlaps : tuple of str
        Pairs of shapes that overlap at the start: depth, energy of the law, and speed it gives.
    """

    name: str
    rows: int = 0
    mobility: int | None = None
    rigid_mobility: int | None = None
    moving: tuple[str, ...] = ()
    driven: tuple[str, ...] = ()
    still: tuple[str, ...] = ()
    dead: tuple[str, ...] = ()
    redundancy: Redundancy | Any = None
    problems: tuple[Problem, ...] = ()
    warnings: tuple[str, ...] = ()
    core: str = ""
    explicit_step: float | None = None
    overlaps: tuple[str, ...] = ()
    fastest: tuple[tuple[str, float], ...] = ()

    def _facts(self) -> str:
        if self.problems:
            return f"cannot be assembled, {count(len(self.problems), 'problem')}"
        facts = [f"{count(self.rows, 'row')}"]
        for what, motions in (("", self.mobility), (" of rigid bodies", self.rigid_mobility)):
            facts += [] if motions is None else [f"{count(motions, 'motion')}{what}"]
        repeated = "" if self.redundancy is None else "rows are redundant"
        noted = count(len(self.warnings), "warning") if self.warnings else ""
        return ", ".join(filter(None, [*facts, repeated, noted]))

    @property
    def healthy(self) -> bool:
        """Whether the mechanism can be assembled without redundant rows."""
        return not self.problems and self.redundancy is None

    def lines(self) -> list[tuple[str, str]]:
        """Return names and values of the findings, one pair per line."""
        out: list[tuple[str, str]] = []
        if self.mobility is not None:
            text = f"{count(self.rows, 'constraint row')} leave{'s' * (self.rows == 1)} "
            elastic = self.mobility - (
                self.mobility if self.rigid_mobility is None else self.rigid_mobility
            )
            if elastic:
                text += f"{count(self.mobility - elastic, 'motion')} as a mechanism"
                text += f", plus {count(elastic, 'elastic mode')}"
            else:
                text += count(self.mobility, "free motion")
            out.append(("mobility", text))
        if self.driven:
            out.append(("moves as driven", ", ".join(self.driven)))
        if self.dead:
            text = (
                f"{', '.join(self.dead)}: fixed at this position only, movable at neighbouring ones"
            )
            out.append(("dead centre", text))
        if self.still:
            out.append(("cannot move", ", ".join(self.still)))
        if self.redundancy is not None:
            out.append(("repeated rows", self.redundancy.sentence))
        if self.core and not self.core.startswith(BODIES):
            out.append(("runs in", self.core))
        if self.explicit_step is not None:
            text = f"RK4 needs a step below {1e3 * self.explicit_step:.3g} ms for the gear springs"
            out.append(("explicit", text))
        if self.fastest:
            out.append(("fastest states", _step_advice(self.fastest)))
        if self.overlaps:
            shown = ", ".join(self.overlaps[:SHOWN]) + (", ..." if self.overlaps[SHOWN:] else "")
            text = f"{shown}; move the bodies apart, or start from jo.equilibrium"
            out.append(("overlap at the start", text))
        out += [("problem", str(problem)) for problem in self.problems]
        out += [("warning", text) for text in self.warnings]
        return out

    def __str__(self) -> str:
        """Return all findings as text."""
        return "\n".join(f"{name}: {text}" for name, text in self.lines())


@uncollected()
@explained
def doctor(mechanism: Mechanism | Model | Run) -> Diagnosis:
    """Return the mobility of a mechanism, and its redundant and contradictory joints.

    For a mechanism that cannot be assembled no error is raised: the result contains the reasons.
    Of contacts, shapes that overlap at the start are found. For a run, the warnings are about its
    contacts: fewer than 10 steps, too deep for the size of the shapes, another restitution than
    asked for, steps in which a contact may have been missed; and valves that open within a step;
    each with its remedy.

    Parameters
    ----------
    mechanism : Mechanism, Model or Solution
        Mechanism at its initial pose, or a run of it. Loads that the modes represent badly are
        found with the full models of the parts.

    Returns
    -------
    Diagnosis
        Mobility, bodies that cannot move, redundant rows with remedies, and conflicts.

    Examples
    --------
    >>> import jousto as jo
    >>> wheel = jo.RigidBody("wheel", 3.0, (0.01, 0.01, 0.02), angular_velocity=(0, 0, 9))
    >>> axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    >>> print(jo.doctor(jo.Mechanism(wheel, axle)))
    mobility: 5 constraint rows leave 1 free motion
    runs in: joint coordinates (1 of a tree)
    """
    if not isinstance(mechanism, Mechanism | Model):
        openings = mechanism.attributes.get("openings")
        found = mechanism.contacts.findings
        return Diagnosis(mechanism.name, warnings=(*found, openings) if openings else found)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", JoustoWarning)
        try:
            model = compile(mechanism) if isinstance(mechanism, Mechanism) else mechanism
        except InputError as error:
            return Diagnosis(mechanism.name, problems=error.problems)
        for where, sentence in unheld_loads(model):
            warn(where, sentence)
    found = repeated_rows(model) if model.redundant else None
    messages = tuple(
        dict.fromkeys(
            str(w.message)
            for w in caught
            if issubclass(w.category, JoustoWarning)
            and not (found is not None and found.sentence in str(w.message))
        )
    )
    mobility = model.nv - model.permanent + (found.count if found else 0)
    diagnosis = Diagnosis(
        model.name,
        rows=model.permanent,
        mobility=mobility,
        redundancy=found,
        warnings=messages,
        core=core_of(model),
        explicit_step=explicit_step(model),
        overlaps=_overlaps(model),
        fastest=_fastest(mechanism),
    )
    return _with_motions(diagnosis, model)


def _fastest(mechanism: Mechanism | Model) -> tuple[tuple[str, float], ...]:
    """Return the states with the largest bounds of their rates, 1/s, the fastest first."""
    blocks = mechanism.blocks if isinstance(mechanism, Mechanism) else ()
    rates = [pair for block in blocks for pair in block.fastest.items()]
    return tuple(sorted(rates, key=lambda pair: -pair[1])[:FEW])


def _step_advice(fastest: tuple[tuple[str, float], ...]) -> str:
    """Return the rates, and the steps that methods need."""
    shown = ", ".join(f"{name} up to {rate:.3g} 1/s" for name, rate in fastest)
    if not fastest[0][1] > 0.0:
        return shown
    step = RK4_STABLE / fastest[0][1]
    return (
        f"{shown}; RK4 and DormandPrince need steps below {step:.2g} s while its edges are fully "
        "open at no pressure drop, ROS2 and GeneralizedAlpha (rho up to 0.8) do not; take one of "
        "these, or a larger volume there"
    )


def _overlaps(model: Model) -> tuple[str, ...]:
    """Return the pairs of shapes that overlap at the start, the deepest first."""
    return tuple(
        f"'{one.contact}' ({one.first} - {one.second}) by {one.text}" for one in overlaps(model)
    )


def _with_motions(diagnosis: Diagnosis, model: Model) -> Diagnosis:
    """Add the mobility and the movable bodies."""
    here = moving(model, model.q0)
    bare = without_drives(model) if any(is_drive(joint) for joint in model.joints) else model
    loose = here if bare is model else moving(bare, model.q0)
    still = {b.name for b in model.bodies} - loose
    beside = neighbour(bare) if still else None
    dead = set() if beside is None else still & moving(replace(bare, redundant=True), beside)
    return replace(
        diagnosis,
        rigid_mobility=_rigid_mobility(diagnosis, model),
        moving=_names(model, here),
        driven=_names(model, loose - here),
        dead=_names(model, dead),
        still=_names(model, still - dead),
    )


def _rigid_mobility(diagnosis: Diagnosis, model: Model) -> int | None:
    """Return the mobility with rigid bodies, None if its computation takes too long."""
    if not model.beam_shapes and all(body.n == 0 for body in model.bodies):
        return diagnosis.mobility
    if model.nv > LARGE:
        return None
    engine = Engine(model, implicit=False)
    rigid = _rigid_rows(model, engine, unit_rows(model, engine))
    s = np.linalg.svd(rigid, compute_uv=False)
    return int(rigid.shape[1]) - int((s > RANK).sum())


def _rigid_rows(model: Model, engine: Engine, G: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows for rigid motions of all bodies, six columns each; a beam is one body."""
    beams = [[int(i) for i in beam.bodies] for beam in model.beam_shapes]
    inside = {i for nodes in beams for i in nodes}
    columns = [G[:, b.iv : b.iv + 6] for i, b in enumerate(model.bodies) if i not in inside]
    if not beams:
        return np.hstack(columns)
    C = constraint_matrix(model, engine)  # rates [R' (world), w (local)]
    for nodes in beams:
        turned = np.zeros((len(C), 6))
        first = model.bodies[nodes[0]].iq
        for i in nodes:
            b = model.bodies[i]
            arm = skew(engine.q[b.iq : b.iq + 3] - engine.q[first : first + 3])
            A = rotation_matrix(engine.q[b.iq + 3 : b.iq + 7])
            move, turn = C[:, b.iv : b.iv + 3], C[:, b.iv + 3 : b.iv + 6]
            turned += np.hstack([move, turn @ A.T - move @ arm])
        columns.append(turned / max(float(np.linalg.norm(turned, axis=1).max()), 1e-300))
    rows = np.hstack(columns)
    length = np.linalg.norm(rows, axis=1)
    return np.asarray(rows / np.where(length > 0.0, length, 1.0)[:, None])


def _names(model: Model, which: set[str]) -> tuple[str, ...]:
    """Return the names of bodies in their order; a beam with all its nodes is one name."""
    whole: dict[str, str] = {}
    for beam in model.beam_shapes:
        nodes = [model.bodies[int(i)].name for i in beam.bodies]
        if which.issuperset(nodes):
            whole |= dict.fromkeys(nodes, beam.name)
    names = (whole.get(b.name, b.name) for b in model.bodies if b.name in which)
    return tuple(dict.fromkeys(names))
