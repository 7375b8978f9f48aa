"""REDUCE: a part with a mesh becomes a few modes, invariants and modal stress."""

from __future__ import annotations

from jousto.reduction.advice import Advice, advise
from jousto.reduction.cache import ReductionCache
from jousto.reduction.certificate import Certificate, Check, Silhouette, Table, certify
from jousto.reduction.clamp import clamp
from jousto.reduction.damping import Damping, Rayleigh, modal_damping
from jousto.reduction.factor import SolverInfo, solvers
from jousto.reduction.invariants import Invariants
from jousto.reduction.memory import MemoryEstimate, memory_estimate
from jousto.reduction.methods import CraigBampton, FreeFree, Method
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.reduction.relief import InertiaRelief, inertia_relief
from jousto.reduction.stiffening import Stiffening
from jousto.reduction.stress import StressModes
from jousto.reduction.superelement import reduce_superelement

__all__ = [
    "reduce_superelement",
    "Advice",
    "Certificate",
    "Check",
    "CraigBampton",
    "Damping",
    "FreeFree",
    "InertiaRelief",
    "Invariants",
    "MemoryEstimate",
    "Method",
    "Rayleigh",
    "ReducedPart",
    "Silhouette",
    "ReductionCache",
    "SolverInfo",
    "Stiffening",
    "StressModes",
    "Table",
    "advise",
    "certify",
    "clamp",
    "inertia_relief",
    "memory_estimate",
    "modal_damping",
    "reduce",
    "solvers",
]
