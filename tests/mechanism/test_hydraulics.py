"""Hydraulic networks: what is refused before the run, by name and with a remedy."""

from __future__ import annotations

from typing import Any

import pytest

import jousto as jo
from jousto.base.declare import kinds
from jousto.base.errors import InputError
from jousto.hydraulics import (
    Accumulator,
    CheckValve,
    FlowSource,
    Hose,
    HydraulicCylinder,
    HydraulicNetwork,
    Leak,
    Node,
    Oil,
    Orifice,
    Pump,
    ReliefValve,
    Supply,
    Tank,
)

ROD = jo.RigidBody("rod", 1.0, (1, 1, 1), position=(1.0, 0, 0))
SIZE = {"bore": 0.05, "rod": 0.03, "stroke": 0.4, "closed": 0.8}


def cylinder(**changed: Any) -> HydraulicCylinder:
    ends = jo.ground["origin"], ROD["origin"]
    return HydraulicCylinder("lift", *ends, "A", "B", **{**SIZE, **changed})


def network(*elements: Any, **options: Any) -> HydraulicNetwork:
    return HydraulicNetwork("oil", elements, **options)


LEAK = Leak("leak", "A", "T", 1e-12)
REFUSED: dict[str, tuple[Any, str]] = {
    "port without node": (
        lambda: network(Tank("T"), Node("A", 1.0), Leak("leak", "A", "TT", 1e-12)),
        r"b of leak 'leak' is 'TT', which is no node, tank or supply; did you mean 'T'",
    ),
    "port without any node": (
        lambda: network(Tank("tank"), LEAK, Leak("second", "tank", "A", 1.0)),
        r"add Node\('A', volume\)",
    ),
    "node without volume": (
        lambda: network(Tank("T"), Node("A"), LEAK),
        r"node 'A' has the volume 0 m3 at an end of the strokes, must be positive; give it",
    ),
    "chamber without volume at an end": (
        lambda: network(Node("A"), Node("B"), cylinder(rod_volume=0.0)),
        r"node 'B' has the volume 0 m3",
    ),
    "supply without tank": (
        lambda: network(Supply("A", 1e6), Node("B", 1.0), Orifice("o", "A", "B", flow=1.0)),
        r"has a supply but no tank; add Tank",
    ),
    "source without tank": (
        lambda: network(Node("A", 1.0), FlowSource("o", "A", 1.0)),
        r"has a supply but no tank",
    ),
    "nothing connected": (
        lambda: network(Tank("T"), Node("A", 1.0), Node("B", 1.0), LEAK),
        r"nothing is connected to node 'B'",
    ),
    "same name": (
        lambda: network(Tank("T"), Node("A", 1.0), LEAK, LEAK),
        r"has two elements 'leak'; give each its own name",
    ),
    "setting above burst": (
        lambda: network(
            *(Tank("T"), Node("A", 1.0), Node("B", 1.0)),
            Hose("h", "A", "B", 1.0, 0.01, burst=30e6),
            ReliefValve("r", "B", "T", setting=40e6, flow=1e-3),
        ),
        r"relief valve 'r' opens at 4e\+07 Pa, above the burst pressure 3e\+07 Pa of hose 'h'",
    ),
    "start above burst": (
        lambda: network(
            *(Node("A", 1.0), Node("B", 1.0, start=31e6)),
            Hose("h", "A", "B", 1.0, 0.01, burst=30e6),
        ),
        r"'B' starts at 3.1e\+07 Pa, above the burst pressure",
    ),
    "hose that ends at a tank": (
        lambda: network(Tank("T"), Node("A", 1.0), Hose("h", "A", "T", 1.0, 0.01)),
        r"b is 'T', must be a node; swap a and b",
    ),
    "accumulator without precharge": (
        lambda: Accumulator("gas", "A", 1e-3, 0.0),
        r"precharge is 0 Pa, must be positive",
    ),
    "precharge above the largest pressure": (
        lambda: Accumulator("gas", "A", 1e-3, 30e6, most=20e6),
        r"precharge is 3e\+07 Pa, must be below its largest pressure 2e\+07 Pa",
    ),
    "outside the stroke": (
        lambda: network(Node("A"), Node("B"), cylinder(closed=0.5)),
        r"the markers are 1 m apart, which is not within closed to closed \+ stroke, 0.5 to 0.9 m",
    ),
    "rod above bore": (lambda: cylinder(rod=0.06), r"rod is 0.06 m, must be below the bore 0.05 m"),
    "bar given as Pa": (
        lambda: network(Tank("T"), Node("A", 1.0), ReliefValve("r", "A", "T", setting=210, flow=1)),
        r"setting of relief valve 'r' is 210 Pa.*write 2.1e\+07 for 210 bar",
    ),
    "mass with air": (
        lambda: network(Tank("T"), Node("A", 1.0), LEAK, oil=Oil(air=0.01), flow="mass"),
        r"flow 'mass' is not available with free air, accumulators or hoses; take flow='volume'",
    ),
    "check valve that is always open": (
        lambda: CheckValve("c", "A", "B", flow=1.0, cracking=1e5, full=1e5),
        r"is fully open at 100000 Pa, must be above the cracking pressure 100000 Pa",
    ),
    "pump with two drives": (
        lambda: Pump("p", "A", "B", 1e-6),
        r"give either speed or shaft, the angle of a joint",
    ),
    "name with a space": (lambda: Node("a b"), r"letters, digits and _ only"),
    "stuck without dynamics": (
        lambda: jo.hydraulics.DirectionalValve("v", "P", "T", "A", flow=1.0, stuck=1.0),
        r"stuck needs a spool with dynamics; give its frequency",
    ),
    "signal that is no number": (
        lambda: Orifice("o", "A", "B", flow=1.0, opening=[1.0]),
        r"opening is \[1.0\], must be an expression of states, inputs, numbers, signals",
    ),
}


@pytest.mark.filterwarnings("error::jousto.JoustoWarning")
@pytest.mark.parametrize("what", REFUSED)
def test_what_is_refused(what: str) -> None:
    make, message = REFUSED[what]
    with pytest.raises((InputError, jo.JoustoWarning), match=message):
        make()


def test_mass_flow_starts_in_the_declared_pose() -> None:
    body = jo.RigidBody("rod", 1.0, (1, 1, 1), position=(1.0, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    lift = HydraulicCylinder("lift", jo.ground["origin"], body["origin"], "A", "B", **SIZE)
    oil = network(Node("A"), Node("B"), lift, flow="mass")
    jo.Mechanism(body, rail, oil, jo.Initial(rail.displacement, rate=0.1))
    with pytest.raises(InputError, match="has the oil of the declared pose at the start"):
        jo.Mechanism(body, rail, oil, jo.Initial(rail.displacement, value=0.1))


def test_every_element_is_public() -> None:
    found = kinds("hydraulics", "jousto.mechanism.hydraulics").values()
    public = {getattr(jo.hydraulics, name) for name in jo.hydraulics.__all__}
    assert set(found) <= public
    assert public - set(found) == {
        *(HydraulicNetwork, Oil, jo.hydraulics.Cushion, jo.hydraulics.EfficiencyMap),
    }
