# names of jo.robots; they are loaded from here when they are first used
from .build import mechanism as mechanism
from .description import (
    Frame as Frame,
    Link as Link,
    Mimic as Mimic,
    Robot as Robot,
    RobotJoint as RobotJoint,
)
from .dh import DHRow as DHRow, from_dh as from_dh
from .files import read_robot as read_robot
from .in_mechanism import RobotInMechanism as RobotInMechanism
from .inverse import IKResult as IKResult, inverse_kinematics as inverse_kinematics
from .mjcf import read_mjcf as read_mjcf
from .sdf import read_sdf as read_sdf
from .state_at import state_at as state_at
from .tree import Tree as Tree
from .urdf import read_urdf as read_urdf
