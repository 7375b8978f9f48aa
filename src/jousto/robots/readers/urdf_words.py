"""Words of URDF, with those of Gazebo, and the treatment of each by `read_urdf`."""

from __future__ import annotations

from jousto.robots.readers.words import QUIET_TAG, Format, Tag, warned

WEIGHT = (
    "the weight acts on this link, and no spring on this joint, even with other settings for Gazebo"
)
ONE_LAW = "contact: one law for all shapes; contact='file' takes kp and kd of the file"
_pose = Tag(done="xyz rpy quat_xyzw")
_transmission = Tag(done="type plugin", quiet="name")
_end = Tag(
    done="name mechanicalReduction mechanical_reduction",
    quiet="role offset hardwareInterface motorTorqueConstant",
)

TAGS = {
    "/robot": Tag(done="name", quiet="version"),
    "robot/link": Tag(done="name", quiet="type"),
    "robot/joint": Tag(done="name type"),
    "robot/material": QUIET_TAG,
    "robot/sensor": QUIET_TAG,
    "robot/group": QUIET_TAG,
    "robot/transmission": _transmission,
    "robot/ros2_control": Tag(quiet="name type", free=True),
    "ros2_control/hardware": QUIET_TAG,
    "ros2_control/joint": QUIET_TAG,
    "ros2_control/sensor": QUIET_TAG,
    "ros2_control/gpio": QUIET_TAG,
    "ros2_control/transmission": _transmission,
    "transmission/joint": _end,
    "transmission/actuator": _end,
    "transmission/mechanicalReduction": Tag(done="value"),
    # of transmissions of other types, which are named in a warning
    "transmission/leftActuator": QUIET_TAG,
    "transmission/rightActuator": QUIET_TAG,
    "transmission/flexJoint": QUIET_TAG,
    "transmission/rollJoint": QUIET_TAG,
    "transmission/gap_joint": QUIET_TAG,
    "transmission/passive_joint": QUIET_TAG,
    "transmission/use_simulated_gripper_joint": QUIET_TAG,
    "robot/gazebo": Tag(
        done="mu1 mu",
        quiet="reference",
        words={
            "mu2 kp kd minDepth maxVel": warned(ONE_LAW, silent=True),
            "gravity": warned(WEIGHT, "true", "1"),
            "turnGravityOff": warned(WEIGHT, "false", "0"),
            "springStiffness springReference": warned(WEIGHT, "0"),
        },
        free=True,
    ),
    "link/inertial": Tag(),
    "link/visual": Tag(quiet="name group"),
    "link/collision": QUIET_TAG,
    "link/sensor": QUIET_TAG,
    "link/material": QUIET_TAG,
    "link/gazebo": QUIET_TAG,
    "inertial/origin": _pose,
    "inertial/mass": Tag(done="value"),
    "inertial/inertia": Tag(done="ixx ixy ixz iyy iyz izz"),
    "visual/origin": _pose,
    "visual/geometry": Tag(),
    "visual/material": QUIET_TAG,
    "geometry/box": Tag(done="size"),
    "geometry/cylinder": Tag(done="radius length"),
    "geometry/capsule": Tag(done="radius length"),
    "geometry/sphere": Tag(done="radius"),
    "geometry/mesh": Tag(done="filename scale"),
    "joint/origin": _pose,
    "joint/parent": Tag(done="link"),
    "joint/child": Tag(done="link"),
    "joint/axis": Tag(done="xyz"),
    "joint/limit": Tag(done="lower upper effort velocity", quiet="acceleration deceleration jerk"),
    "joint/dynamics": Tag(done="damping friction armature"),
    "joint/mimic": Tag(done="joint multiplier offset"),
    "joint/calibration": QUIET_TAG,
    "joint/safety_controller": QUIET_TAG,
    "joint/gazebo": QUIET_TAG,
    "joint/sensor": QUIET_TAG,
    "joint/material": QUIET_TAG,
}
URDF = Format("URDF", TAGS)
