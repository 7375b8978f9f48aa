"""Meshes and height fields of robot files touch as in MuJoCo: places, distances, rest."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import ConvexHull, HeightField
from jousto.model import shape_distance
from jousto.robots import Robot, mechanism, read_urdf
from robots.peers import peer, read, write

pytestmark = pytest.mark.filterwarnings("ignore:.*contact is off", "ignore:.*moves freely")

CORNERS = np.array([(0, 0, 0), (0.3, 0, 0), (0, 0.2, 0), (0, 0, 0.1), (0.25, 0.15, 0.08)])
FACES = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 4, 3), (3, 4, 2), (2, 4, 1)])


def stl(path: Path, x: Any = CORNERS, faces: Any = FACES) -> Path:
    """Write a binary STL file."""
    data = b"".join(
        struct.pack("<12fH", 0, 0, 0, *np.ravel(np.asarray(x)[f]).tolist(), 0) for f in faces
    )
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + data)
    return path


def obj(path: Path) -> Path:
    lines = [f"v {a:g} {b:g} {c:g}" for a, b, c in CORNERS]
    lines += [f"f {a} {b} {c}" for a, b, c in FACES + 1]
    return write(path.parent, "\n".join(lines) + "\n", path.name)


def msh(path: Path) -> Path:
    """Write MuJoCo's own format: counts, vertices, faces."""
    counts = struct.pack("<4i", len(CORNERS), 0, 0, len(FACES))
    path.write_bytes(counts + CORNERS.astype("<f4").tobytes() + FACES.astype("<i4").tobytes())
    return path


INLINE = " ".join(map(str, CORNERS.ravel()))
MODEL = f"""<mujoco><asset>
<mesh name="a" file="a.stl" refpos=".1 .02 .03" refquat=".5 .5 -.5 .5" scale="2 3 -4"/>
<mesh name="b" file="b.obj" scale="1.5 1 1"/>
<mesh name="c" file="c.msh"/>
<mesh name="d" refpos=".1 0 .2" scale="1 1 -1"
 vertex="{INLINE} .2 .2 .2"/>
<mesh name="e" refpos="0 .1 .2" vertex="{INLINE} 1 0 0 1.1 0 0 1 .1 0 1 0 .1"
 face="0 2 1 0 1 3 0 3 2 1 4 3 3 4 2 2 4 1"/>
</asset><worldbody>
<geom name="floor" type="plane" size="9 9 1"/>
<body pos="0 0 3"><freejoint/>
<geom name="a" type="mesh" mesh="a" pos=".1 .2 .3" euler="9 20 3"/></body>
<body pos="2 0 3"><freejoint/><geom name="b" type="mesh" mesh="b" pos=".1 .2 .3"/></body>
<body pos="2 2 3"><freejoint/><geom name="c" type="mesh" mesh="c" euler="90 0 40"/></body>
<body pos="0 2 3"><freejoint/><geom name="d" type="mesh" mesh="d" euler="0 50 0"/></body>
<body pos="0 4 3"><freejoint/><geom name="e" type="mesh" mesh="e"/></body>
<body pos="2 4 3"><freejoint/><geom name="f" type="box" mesh="a" euler="10 20 30"/></body>
<body pos="4 4 3"><freejoint/><geom name="g" type="capsule" mesh="b" fitscale="1.2"/></body>
</worldbody></mujoco>"""


def test_meshes_lie_where_mujoco_has_them(tmp_path):
    """Distances of all pairs; MuJoCo moves each mesh to its inertia frame and the geom back.

    Its vertices have single precision, its distances a tolerance of 1e-6 m.
    """
    mujoco = pytest.importorskip("mujoco")
    stl(tmp_path / "a.stl"), obj(tmp_path / "b.obj"), msh(tmp_path / "c.msh")
    path = write(tmp_path, MODEL)
    model, robot = peer(path), read(path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    frames = dict(zip([link.name for link in robot.links], data.xpos, strict=True))
    shapes = {
        one.name: (one.shape, frames[link.name] + one.frame.r, one.frame.A)
        for link in robot.links
        for one in link.collisions
    }
    assert len(shapes) == model.ngeom
    assert not robot.untouching
    compared = 0
    for i in range(model.ngeom):
        for j in range(i):
            one, other = (mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, k) for k in (i, j))
            theirs = mujoco.mj_geomDistance(model, data, j, i, 20.0, np.zeros(6))
            (a, r, A), (b, x, B) = shapes[other], shapes[one]
            gap, _ = shape_distance(a, b, A.T @ (x - r), A.T @ B)
            assert gap == pytest.approx(theirs, abs=3e-6), (one, other)
            compared += 1
    assert compared == 28


def hull_text(robot: Robot) -> str:
    return "; ".join(f"{name}: {text}" for name, text in robot.shape_facts)


def test_what_each_geom_became_is_listed(tmp_path):
    stl(tmp_path / "a.stl"), obj(tmp_path / "b.obj"), msh(tmp_path / "c.msh")
    text = hull_text(read(write(tmp_path, MODEL)))
    assert "shape c: hull of the mesh 'c', 5 vertices, 6 faces, on" in text
    assert "shape f: box fitted to the mesh 'a'" in text
    assert "HalfSpace" in text


GROUND = """<mujoco><option timestep=".001"/><asset>
<hfield name="h" nrow="3" ncol="5" size="2 1 .3 .1" elevation="{rows}"/>
<mesh name="m" file="a.stl"/></asset><worldbody>
<geom name="ground" type="hfield" hfield="h" pos=".1 0 0"/>
<body name="ball" pos="{at}"><freejoint/><geom size=".05" mass="1"/></body>
</worldbody></mujoco>"""
ROWS = "9 5 5 5 9  8 2 0 1 8  6 4 4 3 7"


def test_height_field_is_that_of_mujoco(tmp_path):
    """A ball at many places: the same distance, rows from the largest y to the smallest."""
    mujoco = pytest.importorskip("mujoco")
    stl(tmp_path / "a.stl")
    path = write(tmp_path, GROUND.format(rows=ROWS, at="0 0 1"))
    model, robot = peer(path), read(path)
    (ground,) = [one for link in robot.links for one in link.collisions if one.name == "ground"]
    assert isinstance(ground.shape, HeightField)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(2)
    compared = 0
    for _ in range(200):
        place = rng.uniform((-1.5, -0.8, 0.0), (1.5, 0.8, 0.3))
        data.qpos[:3] = place
        mujoco.mj_forward(model, data)
        gap, _ = shape_distance(ground.shape, jo.mechanism.Sphere(0.05), place - ground.frame.r)
        if -0.02 < gap < -1e-3:  # contacts; deeper, MuJoCo leaves by other sides of its prisms
            assert data.contact.dist.min() == pytest.approx(gap, abs=1e-4)
            compared += 1
        elif gap > 1e-3:
            assert data.ncon == 0
    assert compared > 10


WEDGE = """<mujoco><option timestep=".001"/><asset>
<mesh name="m" file="a.stl" scale="1 1 1.5"/></asset>
<worldbody><geom name="floor" type="plane" size="9 9 1"/>
<body name="part" pos="0 0 .3" quat="{q}"><freejoint/>
<geom name="part" type="mesh" mesh="m" mass="2"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("q", ["1 0 0 0", ".8 .6 0 0", ".2 .7 .3 -.5"])
def test_part_comes_to_rest_as_in_mujoco(tmp_path, q):
    """Dropped, it lies on the same face, at the same height but for both depths, by its weight."""
    mujoco = pytest.importorskip("mujoco")
    stl(tmp_path / "a.stl")
    path = write(tmp_path, WEDGE.format(q=q))
    model, robot = peer(path), read(path)
    data = mujoco.MjData(model)
    for _ in range(3000):
        mujoco.mj_step(model, data)
    machine = mechanism(robot, contact=True)
    force = jo.mechanism.ContactForceSensor(
        "force", next(f for f in machine.forces if f.name == "contacts"), "floor", "part"
    )
    machine = jo.Mechanism(*machine.items, force)
    run = jo.simulate(jo.compile(machine), 3.0, solver=jo.ROS2(2e-3), output_step=0.01)
    up, theirs = (rotation(x)[2] for x in (run.q[-1, 3:7], data.qpos[3:7]))
    assert up == pytest.approx(theirs, abs=5e-3)  # MuJoCo's contacts give way by 1 mm
    assert run.q[-1, 2] == pytest.approx(data.qpos[2], abs=1e-3)
    assert run["force"][-1, :3] == pytest.approx([0, 0, 2 * 9.81], abs=1e-6)


def rotation(e: Any) -> Any:
    from jousto.base.rotations import rotation_matrix

    return rotation_matrix(np.asarray(e) / np.linalg.norm(e))


URDF = """<robot name="r"><link name="base"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.5 0 0" rpy="0 0 1"/><geometry>
<mesh filename="package://parts/{file}" scale="{scale}"/></geometry></collision></link></robot>"""


def test_urdf_meshes_touch_by_their_hulls(tmp_path):
    """An L of two boxes: the hull fills its corner, and a warning says by how much."""
    from scipy.spatial import ConvexHull as Qhull

    x = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
    low, high = np.c_[x, np.zeros(6)], np.c_[x, np.ones(6)]
    cap = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in cap] + [(6 + a, 6 + b, 6 + c) for a, b, c in cap]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, 6 + j), (i, 6 + j, 6 + i)]
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    stl(folder / "l.stl", 1000.0 * np.r_[low, high], np.array(faces))
    path = write(tmp_path, URDF.format(file="l.stl", scale=".001 .001 .001"), "r.urdf")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        robot = read_urdf(path, packages={"parts": folder}, fixed_base=False)
    (one,) = robot.links[0].collisions or robot.links[1].collisions
    assert isinstance(one.shape, ConvexHull)
    assert Qhull(one.shape.polytope.vertices).volume == pytest.approx(3.5)
    assert sorted(len(face) for face in one.shape.polytope.faces) == [4, 4, 4, 4, 4, 5, 5]
    assert one.frame.r == pytest.approx([0.5, 0, 0])
    assert "encloses 17 % more than the mesh" in hull_text(robot)


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("none.stl", "mesh 'package://parts/none.stl' is not there"),
        ("flat.stl", "mesh 'flat.stl': its points have no convex hull with a volume"),
    ],
)
def test_meshes_that_cannot_touch_are_named_with_the_reason(tmp_path, file, said):
    flat = CORNERS.copy()
    flat[:, 2] = 0.0
    stl(tmp_path / "flat.stl", flat, FACES[:2])
    path = write(tmp_path, URDF.format(file=file, scale="1 1 1"), "r.urdf")
    robot = read_urdf(path, packages={"parts": tmp_path})
    assert robot.untouching == (said,)
    assert ("touches nothing", said) in robot.shape_facts


def test_faces_of_files_with_six_digits_stay_whole():
    """The corners of a turned box, rounded as in an OBJ file, have six faces."""
    from jousto.robots.readers.collisions import mesh_hull

    rng = np.random.default_rng(5)
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * [0.3, 0.2, 0.1]
    for _ in range(20):
        A, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        x = np.array([[float(f"{c:.6g}") for c in row] for row in corners @ A.T + [0.7, 0.1, 0.4]])
        assert len(mesh_hull("box", x.reshape(-1, 3)[[[0, 1, 2]]], x).shape.polytope.faces) == 6


def test_hulls_that_are_too_fine_become_coarser_and_say_so():
    from jousto.robots.readers.collisions import mesh_hull

    x = np.random.default_rng(1).normal(size=(3000, 3))
    x /= np.linalg.norm(x, axis=1)[:, None]
    made = mesh_hull("ball", x[:3][None], x)
    vertices = made.shape.polytope.vertices
    assert len(vertices) == 500
    assert "of 3000 vertices, the others up to 0.01" in made.text
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(1.0)


SDF = """<sdf version="1.9"><model name="m"><self_collide>{own}</self_collide><link name="a">
<inertial><mass>1</mass></inertial>
<collision name="ball"><pose>.1 .2 .3 0 0 0</pose><geometry><sphere><radius>.1</radius></sphere>
</geometry><surface><friction><ode><mu>.4</mu><mu2>.4</mu2></ode></friction></surface></collision>
<collision name="wall"><geometry><plane><normal>1 0 0</normal></plane></geometry>
<surface><bounce><restitution_coefficient>.5</restitution_coefficient><threshold>0</threshold>
</bounce></surface></collision>
<collision name="part"><pose>0 0 0 0 0 1.570796326794897</pose><geometry>
<mesh><uri>model://parts/a.stl</uri><scale>2 1 1</scale></mesh></geometry></collision>
<collision name="cone"><geometry><cone><radius>1</radius></cone></geometry></collision>
</link><link name="b"><pose>0 0 -.3 0 0 0</pose><inertial><mass>1</mass></inertial>
<collision name="box"><geometry><box><size>1 1 .1</size></box></geometry></collision>
</link></model></sdf>"""


def test_collisions_of_sdf(tmp_path):
    """The mesh is that of the STL file, twice as long and turned; friction, what is not read."""
    stl(tmp_path / "a.stl")
    path = write(tmp_path, SDF.format(own="true"), "m.sdf")
    with pytest.warns(jo.JoustoWarning, match="contact is off"):
        robot = jo.robots.read_sdf(path, packages={"parts": tmp_path}, fixed_base=False)
    found = {one.name: one for link in robot.links for one in link.collisions}
    assert list(found) == ["a ball", "a wall", "a part", "b box"]
    ball, wall, part = (found[f"a {x}"] for x in ("ball", "wall", "part"))
    assert ball.frame.r == pytest.approx([0.1, 0.2, 0.3])
    assert (ball.friction, ball.unread, wall.unread) == (0.4, (), ("bounce",))
    assert wall.frame.A @ [0, 0, 1] == pytest.approx([1, 0, 0])
    corners = part.shape.polytope.vertices @ part.frame.A.T
    wanted = CORNERS[:, [1, 0, 2]] * [-1, 2, 1]
    for x in wanted:
        assert np.abs(corners - x).max(axis=1).min() < 1e-7
    assert robot.untouching == ("cone",)
    with pytest.warns(jo.JoustoWarning) as said:
        machine = mechanism(robot, contact=True)
    text = "\n".join(str(one.message) for one in said)
    assert "these shapes of the file touch nothing: cone" in text
    assert "bounce of the file are not read" in text
    # of the ball, the part and the plane of a, and the box of b, the plane cuts the box
    model = jo.compile(machine)
    assert "b box" in str(jo.doctor(model).overlaps)


@pytest.mark.filterwarnings("ignore:.*not read", "ignore:.*touch nothing", "ignore:.*pass through")
def test_links_of_sdf_do_not_touch_unless_they_say_so(tmp_path):
    stl(tmp_path / "a.stl")
    path = write(tmp_path, SDF.format(own="false"), "m.sdf")
    robot = jo.robots.read_sdf(path, packages={"parts": tmp_path}, fixed_base=False)
    with pytest.warns(jo.JoustoWarning, match="no two shapes that touch"):
        assert not [one for one in mechanism(robot, contact=True).forces if "contacts" in one.name]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ('nrow="9" ncol="1"', "nrow 9 and ncol 1 must be 2 or more"),
        ('nrow="2000" ncol="2000"', "their product up to 1000000"),
        ('nrow="2" ncol="2" elevation="1 2 3"', "elevation must be 4 numbers"),
        ('file="none.bin"', "is not there"),
        ('file="a.png"', "is no picture that can be read"),
        ('file="a.bin"', "is no file of rows, columns and heights"),
    ],
)
def test_height_fields_that_are_not_read_are_named(tmp_path, words, said):
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n")
    (tmp_path / "a.bin").write_bytes(struct.pack("<2i4f", 2, 3, 1, 2, 3, 4))
    text = f"""<mujoco><asset><hfield name="h" size="1 1 1 1" {words}/></asset>
    <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>"""
    (found,) = read(write(tmp_path, text)).untouching
    assert said in found
