# names of jo.robots; they are loaded from here when they are first used
from .build import mechanism as mechanism
from .description import (
    Frame as Frame,
    Link as Link,
    Mimic as Mimic,
    Robot as Robot,
    RobotJoint as RobotJoint,
)
from .in_mechanism import RobotInMechanism as RobotInMechanism
from .kinematics.inverse_kinematics import (
    IKResult as IKResult,
    inverse_kinematics as inverse_kinematics,
)
from .kinematics.state_at import state_at as state_at
from .kinematics.tree import Tree as Tree
from .readers.denavit_hartenberg import DHRow as DHRow, from_dh as from_dh
from .readers.files import read_robot as read_robot
from .readers.mjcf import read_mjcf as read_mjcf
from .readers.sdf import read_sdf as read_sdf
from .readers.urdf import read_urdf as read_urdf
