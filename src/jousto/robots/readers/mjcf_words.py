"""Words of MJCF (MuJoCo 4.0, mj_printSchema) and the treatment of each by `read_mjcf`."""

from __future__ import annotations

from jousto.robots.readers.words import QUIET_TAG, Format, Tag, Word, refused, warned

OUT_OF_FILE = (
    "is not read; write the model out in full (MuJoCo's mj_saveLastXML does) and read that"
)
CONTACT = (
    "contact is off: bodies that touch pass through each other; contact=True of robots.mechanism "
    "turns it on"
)
SOFT_WORDS = {"solref": None, "solimp": None, "solmix": None, "margin": "0"}
"""Words on the softness of a geom, which one law of contact takes, with the value of no effect."""
UNREAD = {"surfacevel": "0", "adhesion": "0"}
"""Words on the contact of a geom that no law takes, with the value that changes nothing."""
SOFT = "the softness of constraints is not read: limits are stops, and ties are rigid"
MEDIUM = "drag and lift of the medium are left out: bodies move as in a vacuum"
FRAME = "the frame of a free body is its place in the file, from which its coordinates count"
TENDON = (
    "springs, dampers, friction, limits and rotors of tendons are left out: they exert no force"
)
NO_FORCE = (
    "makes no force here; put one on its joint with efforts={joint: signal}, or a force element in "
    "the mechanism"
)
NO_LIMIT = "is kept by position servos alone: what this actuator exerts may exceed it"
LOPSIDED = "is not symmetric; the larger end is the limit of both"
ALONE = "limits each actuator of the joint by itself, not their sum"
DELAY = "the delay of the control signal is left out: the force follows immediately"
LAG = "the dynamics of the actuator are left out: the force follows the control signal immediately"
UNTIED = "is ignored: the bodies that it ties move freely"
POSE = "pos quat axisangle xyaxes zaxis euler"
TOUCH = "contype conaffinity condim friction priority solmix solref solimp margin surfacevel"
SOLVING = (
    "timestep tolerance ls_tolerance noslip_tolerance ccd_tolerance sleep_tolerance "
    "magnetic o_margin o_solref o_solimp o_friction integrator jacobian solver iterations "
    "ls_iterations noslip_iterations ccd_iterations sdf_iterations sdf_initpoints apirate "
    "collision mpr_tolerance mpr_iterations"
)
FLAGS = (
    "clampctrl warmstart filterparent refsafe sensor midphase eulerdamp autoreset nativeccd "
    "island multiccd override energy fwdinv invdiscrete sleep diagexact ipc speculative"
)
CONTROL = "name class joint jointinparent gear ctrlrange ctrllimited forcelimited forcerange"
OTHER_ENDS = "tendon slidersite cranksite site refsite"  # reported by `read_actuators`
_contact = warned(CONTACT, silent=True)
_touch = {TOUCH + " adhesion": _contact}
_soft = {"solref solimp": warned(SOFT)}
_delay = {"delay nsample": warned(DELAY, "0")}
_no_force = Tag(whole=warned(NO_FORCE))


def _actuator(done: str = "", **words: Word) -> Tag:
    return Tag(
        done=f"{CONTROL} group armature damping {OTHER_ENDS} {done}",
        quiet="user lengthrange cranklength interp",
        words=_delay | words,
    )


_tendon = Tag(
    done="name",
    quiet="class group material rgba width user springlength site geom pulley joint",
    words={
        "stiffness damping frictionloss armature": warned(TENDON, "0"),
        "limited range actuatorfrclimited actuatorfrcrange": warned(TENDON, "false", "0"),
        "margin springyield": warned(TENDON, "0"),
        "solreflimit solimplimit solreffriction solimpfriction": warned(SOFT),
    },
)
TAGS: dict[str, Tag] = {
    "/mujoco": Tag(done="model"),
    "mujoco/compiler": Tag(
        done="angle autolimits balanceinertia boundinertia boundmass eulerseq inertiafromgeom "
        "inertiagrouprange meshdir assetdir settotalmass strippath fitaabb exactmeshinertia",
        quiet="discardvisual fusestatic usethread texturedir saveinertial savecanonical "
        "savecompiled passthrough conflict convexhull lengthrange",
        words={
            "alignfree": warned(FRAME, "false"),
            "coordinate": refused(
                "is 'global', which MuJoCo no longer reads; write local", "local"
            ),
        },
    ),
    "compiler/lengthrange": QUIET_TAG,
    "mujoco/option": Tag(
        done="gravity actuatorgroupdisable cone impratio",
        quiet=SOLVING,
        words={"density viscosity wind": warned(MEDIUM, "0")},
    ),
    "option/flag": Tag(
        done="gravity actuation damper spring passive equality frictionloss limit "
        "constraint contact",
        quiet=FLAGS,
    ),
    "mujoco/size": QUIET_TAG,
    "mujoco/statistic": QUIET_TAG,
    "mujoco/visual": QUIET_TAG,
    "mujoco/extension": QUIET_TAG,
    "mujoco/sensor": QUIET_TAG,
    "mujoco/custom": QUIET_TAG,
    "mujoco/keyframe": QUIET_TAG,
    "mujoco/contact": Tag(whole=_contact),
    "mujoco/default": Tag(done="class"),
    "mujoco/asset": Tag(),
    "mujoco/worldbody": Tag(done=f"name {POSE}", quiet="childclass"),
    "mujoco/tendon": Tag(),
    "mujoco/equality": Tag(),
    "mujoco/actuator": Tag(),
    "mujoco/deformable": Tag(),
    "*/include": Tag(done="file"),
    "asset/mesh": Tag(
        done="name class file vertex face scale inertia refpos refquat maxhullvert",
        quiet="content_type normal texcoord smoothnormal material params",
        words={"builtin plugin": warned("the mesh is not created, its shapes are left out")},
    ),
    "asset/hfield": Tag(done="name file nrow ncol elevation size", quiet="content_type"),
    "asset/skin": QUIET_TAG,
    "asset/texture": QUIET_TAG,
    "asset/material": QUIET_TAG,
    "asset/model": Tag(done="name file", quiet="content_type"),
    "body/body": Tag(
        done=f"name childclass gravcomp {POSE}",
        quiet="user sleep simple fuse",
        words={"mocap": warned("it is fixed at its place in the file", "false")},
    ),
    "body/frame": Tag(done=f"childclass {POSE}", quiet="name"),
    "body/replicate": Tag(done="count offset euler sep childclass"),
    "body/attach": Tag(done="model body frame prefix"),
    "body/inertial": Tag(done=f"mass diaginertia fullinertia {POSE}"),
    "body/joint": Tag(
        done="name class type pos axis springdamper limited range stiffness ref springref armature "
        "damping frictionloss actuatorfrcrange actuatorfrclimited",
        quiet="group user",
        words={
            "actuatorgravcomp": warned(
                "gravity compensation acts on the bodies, beside the limit of the joint's force",
                "false",
            ),
            "margin solreflimit solimplimit solreffriction solimpfriction": warned(SOFT, "0"),
            "springyield": refused("is a spring that yields, which is not read", "0"),
        },
    ),
    "body/freejoint": Tag(
        done="name", quiet="group", words={"align": warned(FRAME, "false", "auto")}
    ),
    "body/geom": Tag(
        done="name class type size mass density shellinertia fromto mesh hfield group fitscale "
        f"{POSE}",
        quiet="material rgba castshadow user fluidshape fluidcoef gap",
        words=_touch | {"plugin": refused("makes a shape that is not read; export it as a mesh")},
    ),
    "body/site": Tag(
        done=f"name class fromto {POSE}", quiet="type size group material rgba user mesh"
    ),
    "body/camera": QUIET_TAG,
    "body/light": QUIET_TAG,
    "body/plugin": Tag(whole=refused(OUT_OF_FILE)),
    "body/composite": Tag(whole=refused(OUT_OF_FILE)),
    "body/flexcomp": Tag(whole=refused("is deformable, which is not read from MJCF")),
    "deformable/flex": Tag(whole=refused("is deformable, which is not read from MJCF")),
    "deformable/skin": QUIET_TAG,
    "tendon/spatial": _tendon,
    "tendon/fixed": _tendon,
    "equality/connect": Tag(done="name class active anchor body1 body2 site1 site2", words=_soft),
    "equality/weld": Tag(
        done="name class active anchor body1 body2 relpose site1 site2",
        quiet="torquescale",
        words=_soft,
    ),
    "equality/joint": Tag(done="name class active joint1 joint2 polycoef", words=_soft),
    "equality/tendon": Tag(whole=warned(UNTIED)),
    "equality/flex": Tag(whole=warned(UNTIED)),
    "equality/flexvert": Tag(whole=warned(UNTIED)),
    "equality/flexstrain": Tag(whole=warned(UNTIED)),
    "equality/distance": Tag(whole=warned(UNTIED)),
    "actuator/general": _actuator(
        "gaintype gainprm biastype biasprm dyntype inheritrange",
        **{
            "actdim actearly actlimited actrange dynprm": Word("no effect"),
            "body": warned(NO_FORCE),
            "input ffrange velrange": warned(LAG),
        },
    ),
    "actuator/motor": _actuator(),
    "actuator/position": _actuator("kp kv dampratio inheritrange", timeconst=warned(LAG, "0")),
    "actuator/velocity": _actuator("kv"),
    "actuator/intvelocity": _no_force,
    "actuator/orientation": _no_force,
    "actuator/pid": _no_force,
    "actuator/damper": _no_force,
    "actuator/cylinder": _no_force,
    "actuator/muscle": _no_force,
    "actuator/adhesion": _no_force,
    "actuator/dcmotor": _no_force,
    "actuator/plugin": _no_force,
}
_DEFAULTS = {
    "body": "joint geom site camera light",
    "asset": "mesh texture material",
    "tendon": "spatial",
    "actuator": "general motor position velocity",
}
for _parent, _names in _DEFAULTS.items():
    for _name in _names.split():
        TAGS[f"default/{_name}"] = TAGS[f"{_parent}/{_name}"]
for (
    _name
) in "intvelocity orientation pid damper cylinder muscle adhesion dcmotor pair skin".split():
    TAGS[f"default/{_name}"] = QUIET_TAG  # reported for each element that uses the class
TAGS["default/tendon"] = TAGS.pop("default/spatial")
TAGS["default/equality"] = TAGS["equality/connect"]
TAGS["default/default"] = TAGS["mujoco/default"]
MJCF = Format(
    "MJCF", TAGS, {"worldbody": "body", "frame": "body", "replicate": "body", "(world)body": "body"}
)
