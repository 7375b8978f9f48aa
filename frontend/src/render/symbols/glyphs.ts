/** Unit shapes of symbols, placed and scaled by matrices. */

import * as THREE from "three";

/**
 * cylinder, cone: radius 1 about z from 0 to 1; ball: radius 1; ring: a torus of radius 1 about z;
 * box: from -1/2 to 1/2; gear: a toothed disc of radius 1 and thickness 1; coil: a helix of radius 1
 * from 0 to 1 whose wire keeps its shape when it is stretched; turn: an arrow bent about z.
 */
export type Shape = "cylinder" | "cone" | "ball" | "ring" | "box" | "gear" | "coil" | "turn" | "pyramid" | "octahedron";

export const COILS = 7;

function cylinder(top: number, sides: number): THREE.BufferGeometry {
  return new THREE.CylinderGeometry(top, 1, 1, sides, 1).rotateX(Math.PI / 2).translate(0, 0, 0.5);
}

function gear(): THREE.BufferGeometry {
  const teeth = 18, outline = new THREE.Shape();
  for (let i = 0; i < teeth; i++) {
    for (const [share, radius] of [[0, 0.84], [0.22, 0.84], [0.34, 1], [0.62, 1], [0.76, 0.84]] as const) {
      const angle = (2 * Math.PI * (i + share)) / teeth;
      const x = radius * Math.cos(angle), y = radius * Math.sin(angle);
      if (i === 0 && share === 0) outline.moveTo(x, y);
      else outline.lineTo(x, y);
    }
  }
  const hole = new THREE.Path();
  hole.absarc(0, 0, 0.3, 0, 2 * Math.PI, true);
  outline.holes.push(hole);
  return new THREE.ExtrudeGeometry(outline, { depth: 1, bevelEnabled: false, curveSegments: 10 }).translate(0, 0, -0.5);
}

/** Coordinates along and around the wire; the shader bends it to a coil. */
function coil(): THREE.BufferGeometry {
  const along = 20 * COILS, around = 8;
  const at: number[] = [], index: number[] = [];
  for (let i = 0; i <= along; i++) {
    for (let k = 0; k < around; k++) {
      const angle = (2 * Math.PI * k) / around;
      at.push(i / along, Math.cos(angle), Math.sin(angle));
      if (i === along) continue;
      const a = i * around + k, b = i * around + ((k + 1) % around);
      index.push(a, b, b + around, a, b + around, a + around);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(at, 3));
  geometry.setAttribute("normal", new THREE.Float32BufferAttribute(at, 3));
  geometry.setIndex(index);
  return geometry;
}

/** Three quarters of a ring with an arrow head. */
function turn(): THREE.BufferGeometry {
  const bow = new THREE.TorusGeometry(1, 0.06, 10, 40, 1.5 * Math.PI);
  const head = new THREE.ConeGeometry(0.17, 0.42, 16).translate(0, 0.12, 0).rotateZ(Math.PI / 2).translate(0, -1, 0).rotateZ(0);
  head.applyMatrix4(new THREE.Matrix4().makeRotationY(Math.PI).premultiply(new THREE.Matrix4().makeTranslation(0, 0, 0)));
  return merge([bow, head]);
}

function merge(parts: THREE.BufferGeometry[]): THREE.BufferGeometry {
  const plain = parts.map((part) => (part.index ? part.toNonIndexed() : part));
  const join = (name: string): THREE.Float32BufferAttribute =>
    new THREE.Float32BufferAttribute(plain.flatMap((part) => [...part.getAttribute(name).array]), 3);
  const out = new THREE.BufferGeometry();
  out.setAttribute("position", join("position"));
  out.setAttribute("normal", join("normal"));
  return out;
}

const MADE: Record<Shape, () => THREE.BufferGeometry> = {
  cylinder: () => cylinder(1, 28),
  cone: () => cylinder(0, 28),
  ball: () => new THREE.SphereGeometry(1, 28, 18),
  ring: () => new THREE.TorusGeometry(1, 0.24, 14, 36),
  box: () => new THREE.BoxGeometry(1, 1, 1),
  gear,
  coil,
  turn,
  pyramid: () => new THREE.ConeGeometry(1, 1, 4, 1).toNonIndexed().rotateY(Math.PI / 4).rotateX(Math.PI / 2).translate(0, 0, -0.5),
  octahedron: () => new THREE.OctahedronGeometry(1),
};

export const makeShape = (shape: Shape): THREE.BufferGeometry => {
  const geometry = MADE[shape]();
  if (shape === "pyramid") geometry.computeVertexNormals();
  return geometry;
};
