"""Damage over the bodies of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jousto.base.errors import InputError, Problem, suggest
from jousto.fatigue.miner.damage_field import DamageField
from jousto.scene.scene import Body


def add_damage(bodies: Sequence[Body], fields: Sequence[DamageField]) -> tuple[Body, ...]:
    """Return the bodies with damage and life at their vertices; nan where not computed.

    A vertex has the largest damage and the shortest life of the places at its node.

    Raises
    ------
    InputError
        If the body of a field does not exist, or the field has no nodes.
    """
    found = {body.name: body for body in bodies}
    for one in fields:
        if one.body not in found:
            message = f"there is no body '{one.body}'{suggest(one.body, found)}"
            raise InputError(Problem("damage", message))
        body = found[one.body]
        if one.nodes is None or body.nodes is None:
            raise InputError(
                Problem("damage", f"of '{one.body}' is at places that are not nodes of the body")
            )
        count = int(max(body.nodes.max(), one.nodes.max() + 1))
        there = one.nodes >= 0
        damage, life = np.full(count, -np.inf), np.full(count, np.inf)
        np.maximum.at(damage, one.nodes[there], one.damage[there])
        np.minimum.at(life, one.nodes[there], one.life[there])
        damage[~np.isfinite(damage)] = np.nan
        life[np.isnan(damage)] = np.nan
        at = body.nodes - 1
        found[one.body] = replace(body, damage=damage[at], life=life[at])
    return tuple(found[body.name] for body in bodies)
