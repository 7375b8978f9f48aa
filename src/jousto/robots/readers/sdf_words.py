"""Words of SDF 1.12 and the treatment of each by `read_sdf`."""

from __future__ import annotations

from jousto.robots.readers.words import QUIET_TAG, Format, Tag, refused, warned

OUTSIDE = "is not read; put the model itself into the file"
LEFT = "is left out"
PUSH = "forces of plugins are left out"
WIND = "wind and the forces of fluids are left out: links move as in a vacuum"
SOFT = "the softness of limits is not read: they are stops"
STATE = "is not read: joints start at zero, or at the value of at="
CONTACT = (
    "contact is off: links that touch pass through each other; contact=True of robots.mechanism "
    "turns it on"
)
ONE_LAW = "contact: one law for all shapes; contact='file' takes kp, kd and bounce of the file"
_one_law = warned(ONE_LAW, silent=True)
_off = ("false", "0")
_angles = Tag(done="degrees rotation_format relative_to")
_plugin = Tag(whole=warned(PUSH))
_axis = Tag(done="initial_position use_parent_model_frame")
_model = Tag(
    done="name static self_collide",
    quiet="allow_auto_disable canonical_link namespace",
    words={
        "placement_frame": warned("the pose counts from the frame of the model", ""),
        "enable_wind": warned(WIND, *_off),
    },
)
TAGS = {
    "/sdf": Tag(done="version", quiet="light"),
    "sdf/world": Tag(
        done="name gravity",
        quiet="magnetic_field light",
        words={"wind": warned(WIND)},
    ),
    "sdf/model": _model,
    "sdf/light": QUIET_TAG,
    "sdf/actor": Tag(whole=warned(LEFT)),
    "sdf/include": Tag(whole=refused(OUTSIDE)),
    "world/model": _model,
    "world/include": Tag(whole=refused(OUTSIDE)),
    "world/actor": Tag(whole=warned(LEFT)),
    "world/population": Tag(whole=warned(LEFT)),
    "world/joint": Tag(whole=refused("joins models; put it into one of them")),
    "world/state": Tag(whole=warned(STATE)),
    "world/wind": Tag(words={"linear_velocity": warned(WIND, "0")}),
    "world/plugin": _plugin,
    "world/frame": QUIET_TAG,
    "model/link": Tag(
        done="name gravity self_collide",
        quiet="must_be_base_link light",
        words={
            "enable_wind": warned(WIND, *_off),
            "kinematic": warned("it moves by its forces here", *_off),
        },
    ),
    "model/joint": Tag(
        done="name type parent child gearbox_ratio gearbox_reference_body thread_pitch "
        "screw_thread_pitch"
    ),
    "model/frame": Tag(done="name attached_to"),
    "model/model": _model,
    "model/model_state": Tag(whole=warned(STATE)),
    "model/include": Tag(whole=refused(OUTSIDE)),
    "model/plugin": _plugin,
    "model/gripper": Tag(whole=warned("holds nothing")),
    "link/inertial": Tag(
        done="mass",
        quiet="density auto_inertia_params",
        words={
            "auto": refused(
                "requests the mass from the shapes, which is not computed; give mass and inertia",
                *_off,
            ),
        },
    ),
    "inertial/inertia": Tag(done="ixx ixy ixz iyy iyz izz"),
    "inertial/fluid_added_mass": Tag(
        words={"xx xy xz xp xq xr yy yz yp yq yr zz zp zq zr pp pq pr qq qr rr": warned(WIND, "0")}
    ),
    "link/velocity_decay": Tag(
        words={"linear angular": warned("the decay of velocities is left out", "0")}
    ),
    "link/visual": Tag(done="name", quiet="cast_shadows laser_retro transparency visibility_flags"),
    "link/collision": Tag(
        done="name", quiet="laser_retro max_contacts density auto_inertia_params"
    ),
    "collision/geometry": Tag(
        words={"empty cone heightmap image polyline": warned("touches nothing", silent=True)}
    ),
    "collision/surface": Tag(words={"soft_contact": _one_law}),
    "surface/friction": Tag(words={"bullet": _one_law}),
    "surface/bounce": Tag(words={"restitution_coefficient threshold": _one_law}),
    "surface/contact": Tag(
        words={
            "collide_without_contact collide_without_contact_bitmask collide_bitmask "
            "category_bitmask poissons_ratio elastic_modulus bullet": _one_law
        }
    ),
    "contact/ode": Tag(words={"kp kd soft_cfm soft_erp max_vel min_depth": _one_law}),
    "friction/torsional": Tag(
        done="coefficient patch_radius", words={"use_patch_radius surface_radius ode": _one_law}
    ),
    "friction/ode": Tag(done="mu", words={"mu2 fdir1 slip1 slip2": _one_law}),
    "visual/geometry": Tag(quiet="empty cone heightmap image polyline"),
    "visual/plugin": QUIET_TAG,
    "visual/meta": QUIET_TAG,
    "geometry/plane": Tag(done="normal", quiet="size"),
    "geometry/box": Tag(done="size"),
    "geometry/capsule": Tag(done="radius length"),
    "geometry/cylinder": Tag(done="radius length"),
    "geometry/ellipsoid": Tag(done="radii"),
    "geometry/sphere": Tag(done="radius"),
    "geometry/mesh": Tag(done="uri scale", quiet="optimization convex_decomposition submesh"),
    "joint/axis": _axis,
    "joint/axis2": _axis,
    "joint/physics": QUIET_TAG,
    "axis/xyz": Tag(done="expressed_in"),
    "axis/dynamics": Tag(done="damping friction spring_reference spring_stiffness"),
    "axis/limit": Tag(
        done="lower upper effort velocity",
        words={"stiffness": warned(SOFT, "1e8", "-1"), "dissipation": warned(SOFT, "1", "-1")},
    ),
    "axis/mimic": Tag(
        done="joint multiplier offset reference",
        words={"axis": refused("of a leader with two axes is not read", "axis")},
    ),
    "*/pose": _angles,
}
for _name in "audio atmosphere gui physics scene road spherical_coordinates light".split():
    TAGS[f"world/{_name}"] = QUIET_TAG
for _name in "sensor light projector audio_sink audio_source battery particle_emitter".split():
    TAGS[f"*/{_name}"] = QUIET_TAG
TAGS["*/material"] = QUIET_TAG
SDF = Format("SDF", TAGS, {"axis2": "axis"})
