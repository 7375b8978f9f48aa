"""Write link_arm.step: a cast link arm with an I-section, two bosses and four holes, in mm.

Run it in this folder with the extra ``cad`` installed: ``python link_arm.py``. The arm lies along
x, its bores run along z: one of 90 mm through the boss at the origin, one of 60 mm through the boss
at x = 1200 mm, and two of 80 mm through the web.
"""

import gmsh

LENGTH = 1200.0  # mm, between the bores
DEPTH, WIDTH = 180.0, 110.0  # mm, of the I-section along y and z
FLANGE, WEB = 20.0, 18.0  # mm
FILLET = 12.0  # mm, between web and flanges
BOSSES = ((0.0, 95.0, 45.0, 150.0), (LENGTH, 95.0, 30.0, 130.0))  # x, radius, bore, length, mm
LIGHTENING = ((400.0, 40.0), (800.0, 40.0))  # x, radius, mm


def cylinder(x: float, radius: float, length: float) -> tuple[int, int]:
    """Return a cylinder along z with its middle at (x, 0, 0)."""
    return 3, gmsh.model.occ.addCylinder(x, 0, -length / 2, 0, 0, length, radius)


def beam() -> tuple[int, int]:
    """Return the I-section between the bore axes, with rounded inner corners."""
    occ = gmsh.model.occ
    outer = (3, occ.addBox(0, -DEPTH / 2, -WIDTH / 2, LENGTH, DEPTH, WIDTH))
    inner = DEPTH - 2 * FLANGE
    half = (WIDTH - WEB) / 2
    pockets = []
    for sign in (-1, 1):
        low = -WIDTH / 2 if sign < 0 else WEB / 2
        pockets.append((3, occ.addBox(0, -inner / 2, low, LENGTH, inner, half)))
    cut, _ = occ.cut([outer], pockets)
    occ.synchronize()
    # the four edges along x where the web meets a flange
    edges = [
        tag
        for dim, tag in gmsh.model.getEntities(1)
        if abs(occ.getCenterOfMass(dim, tag)[0] - LENGTH / 2) < 1.0
        and abs(abs(occ.getCenterOfMass(dim, tag)[1]) - inner / 2) < 1.0
        and abs(abs(occ.getCenterOfMass(dim, tag)[2]) - WEB / 2) < 1.0
    ]
    rounded = occ.fillet([cut[0][1]], edges, [FILLET])
    return rounded[0]


def main(path: str = "link_arm.step") -> None:
    """Build the arm and write it."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    gmsh.model.add("link arm")
    occ = gmsh.model.occ
    solids = [cylinder(x, radius, length) for x, radius, _, length in BOSSES]
    arm, _ = occ.fuse([beam()], solids)
    bores = [cylinder(x, bore, 2 * length) for x, _, bore, length in BOSSES]
    bores += [cylinder(x, radius, 2 * WIDTH) for x, radius in LIGHTENING]
    arm, _ = occ.cut(arm, bores)
    occ.synchronize()
    volume = sum(occ.getMass(dim, tag) for dim, tag in arm)
    print(f"{volume * 1e-9 * 7850:.1f} kg of steel, {len(gmsh.model.getEntities(2))} faces")
    gmsh.write(path)
    gmsh.finalize()


if __name__ == "__main__":
    main()
