"""Rigid subtrees in joint coordinates, carried by bodies in maximal coordinates."""

from __future__ import annotations

from dataclasses import replace

from jousto.model.elimination_order import Elimination, eliminate
from jousto.model.hubs import joints_on
from jousto.model.model import JointModel, LinkModel, Model


def is_link(joint: JointModel) -> bool:
    """Return whether a joint connects bodies directly, and does not relate other coordinates."""
    return joint.coincident or bool(joint.perpendicular)


def carried_bodies(model: Model, known: set[int], drives: set[int]) -> dict[int, int]:
    """Return the rigid bodies with joint coordinates, each with its joint towards the ground.

    Leaves of the graph of joints that are connected to a rigid body or to the ground are removed
    repeatedly. The first body on a modal body remains in maximal coordinates, and so do bodies with
    further constraints.

    Parameters
    ----------
    model : Model
        The mechanism.
    known : set of int
        Joints that can be links of the tree.
    drives : set of int
        Drives that prescribe a coordinate of such a joint.
    """
    ends = {
        k: {model.markers[side].body for side in joint.sides}
        for k, joint in enumerate(model.joints)
        if k not in drives
    }
    near: dict[int, set[int]] = {body: set() for body in range(-1, len(model.bodies))}
    for k, bodies in ends.items():
        for body in bodies:
            near[body].add(k)
    carried: dict[int, int] = {}
    waiting = [body for body, joints in near.items() if len(joints) == 1]
    while waiting:
        body = waiting.pop()
        if body < 0 or model.bodies[body].n or len(near[body]) != 1 or body in carried:
            continue
        (k,) = near[body]
        others = ends[k] - {body}
        if k not in known or len(others) != 1:
            continue
        (other,) = others
        if other >= 0 and model.bodies[other].n:
            continue
        carried[body] = k
        near[other].discard(k)
        waiting.append(other)
    return carried


def links_first(model: Model, links: tuple[LinkModel, ...]) -> Elimination:
    """Return an elimination order in which joints that are links come first."""
    inside = {place for link in links for place in (link.joint, link.drive)} - {-1}
    on_body = joints_on(model.joints, model.markers)
    after = {k: inside for k in range(len(model.joints)) if k not in inside}
    return eliminate([joint.rows for joint in model.joints], on_body.values(), after)


def bearers(model: Model) -> list[str]:
    """Return the names of the bodies, or the ground, from which links start."""
    links = model.links
    found = dict.fromkeys(
        links[link.parent].body if link.parent >= 0 else -1
        for link in links
        if link.kind != "body" and (link.parent < 0 or links[link.parent].kind == "body")
    )
    return ["the ground" if body < 0 else f"'{model.bodies[body].name}'" for body in found]


def with_ports(model: Model, links: tuple[LinkModel, ...]) -> Model:
    """Return the model with links, its joints ordered so that those of links can be left out."""
    made = replace(model, tree=links, elimination=links_first(model, links))
    return replace(made, tree_of=made.parts_of_tree)
