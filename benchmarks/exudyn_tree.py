"""A tree of rigid links on hinges in EXUDYN's joint angles: its ObjectKinematicTree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cases import GRAVITY, LENGTH
from exudyn_peer import eii, exu
from machines import CENTER, INERTIA, MASS


def tree(links: Sequence[Any]) -> tuple[Any, Any]:
    """System, not assembled, and the sensor of the end of the last link; links as in trees.py."""
    n, kinds = len(links), exu.JointType
    turns = (kinds.RevoluteX, kinds.RevoluteY, kinds.RevoluteZ)
    mbs = exu.SystemContainer().AddSystem()
    node = mbs.AddNode(
        eii.NodeGenericODE2(
            numberOfODE2Coordinates=n,
            referenceCoordinates=[0.0] * n,
            initialCoordinates=[0.0] * n,
            initialCoordinates_t=[0.0] * n,
        )
    )
    body = mbs.AddObject(
        eii.ObjectKinematicTree(
            nodeNumber=node,
            gravity=list(GRAVITY),
            jointTypes=[turns[int(np.argmax(link.axis))] for link in links],
            linkParents=[link.parent for link in links],
            jointTransformations=exu.Matrix3DList([np.eye(3)] * n),
            jointOffsets=exu.Vector3DList([np.array(link.at) for link in links]),
            linkInertiasCOM=exu.Matrix3DList([np.diag(INERTIA)] * n),
            linkCOMs=exu.Vector3DList([np.array(CENTER)] * n),
            linkMasses=[MASS] * n,
        )
    )
    tip = mbs.AddSensor(
        eii.SensorKinematicTree(
            objectNumber=body,
            linkNumber=n - 1,
            localPosition=[LENGTH, 0.0, 0.0],
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    return mbs, tip
