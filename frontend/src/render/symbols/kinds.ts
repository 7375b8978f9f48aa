/** Shapes of each kind of joint, force, sensor and support. */

import * as THREE from "three";
import type { Cylinder } from "../../protocol";
import type { Shape } from "./glyphs";

/** Placement of a symbol: its points and the axes of its first body. */
export interface Situation {
  points: THREE.Vector3[];
  /** Unit axis of the symbol, world; z of its first body by default. */
  axis: THREE.Vector3;
  /** Two further unit axes perpendicular to it. */
  across: THREE.Vector3;
  third: THREE.Vector3;
  up: THREE.Vector3;
  size: number;
}

/** Draw function of a piece: shape, origin, three matrix columns, colour. */
export type Draw = (
  shape: Shape,
  origin: THREE.Vector3,
  x: THREE.Vector3,
  y: THREE.Vector3,
  z: THREE.Vector3,
  colour: Tint,
) => void;

export type Tint = "joint" | "accent" | "force" | "steel" | "dark" | "ground" | "sensor" | "cable" | "moment" | "motion";

type Kind = (at: Situation, draw: Draw) => void;

const times = (v: THREE.Vector3, f: number): THREE.Vector3 => v.clone().multiplyScalar(f);
const plus = (v: THREE.Vector3, w: THREE.Vector3, f = 1): THREE.Vector3 => v.clone().addScaledVector(w, f);

/** Rotationally symmetric piece along a direction. */
function bar(draw: Draw, shape: Shape, from: THREE.Vector3, along: THREE.Vector3, length: number, radius: number, colour: Tint, across?: THREE.Vector3): void {
  const x = across ?? normalTo(along);
  const y = along.clone().cross(x);
  draw(shape, from, times(x, radius), times(y, radius), times(along, length), colour);
}

/** Unit vector perpendicular to a vector. */
export function normalTo(v: THREE.Vector3): THREE.Vector3 {
  const other = Math.abs(v.x) < 0.7 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
  return other.addScaledVector(v, -other.dot(v)).normalize();
}

const ball = (draw: Draw, at: THREE.Vector3, radius: number, colour: Tint): void =>
  draw("ball", at, new THREE.Vector3(radius, 0, 0), new THREE.Vector3(0, radius, 0), new THREE.Vector3(0, 0, radius), colour);

function brick(draw: Draw, s: Situation, at: THREE.Vector3, x: number, y: number, z: number, colour: Tint): void {
  draw("box", at, times(s.across, x), times(s.third, y), times(s.axis, z), colour);
}

/** Piece along the axis, centred at the point. */
function pin(draw: Draw, s: Situation, radius: number, length: number, colour: Tint, axis = s.axis): void {
  bar(draw, "cylinder", plus(s.points[0], axis, -0.5 * length), axis, length, radius, colour);
}

const ring = (draw: Draw, s: Situation, radius: number, thick: number, colour: Tint): void =>
  draw("ring", s.points[0], times(s.across, radius), times(s.third, radius), times(s.axis, thick), colour);

/** Segment from the first to the last point: start, unit direction and length. */
function span(s: Situation): { a: THREE.Vector3; along: THREE.Vector3; length: number } {
  const a = s.points[0], b = s.points[s.points.length - 1];
  const along = b.clone().sub(a);
  const length = along.length();
  return { a, along: length > 1e-12 ? along.multiplyScalar(1 / length) : s.axis.clone(), length };
}

const revolute: Kind = (s, draw) => {
  pin(draw, s, 0.34 * s.size, 2.4 * s.size, "steel");
  ring(draw, s, 0.62 * s.size, 0.95 * s.size, "joint");
};

const spherical: Kind = (s, draw) => {
  ball(draw, s.points[0], 0.55 * s.size, "steel");
  ring(draw, s, 0.6 * s.size, 0.6 * s.size, "joint");
};

const universal: Kind = (s, draw) => {
  pin(draw, s, 0.24 * s.size, 2 * s.size, "steel");
  pin(draw, s, 0.24 * s.size, 2 * s.size, "steel", s.across);
  ball(draw, s.points[0], 0.42 * s.size, "joint");
};

const cylindrical: Kind = (s, draw) => {
  pin(draw, s, 0.28 * s.size, 4 * s.size, "steel");
  pin(draw, s, 0.6 * s.size, 1.5 * s.size, "joint");
};

const prismatic: Kind = (s, draw) => {
  brick(draw, s, s.points[0], 0.5 * s.size, 0.5 * s.size, 4 * s.size, "steel");
  brick(draw, s, s.points[0], 1.1 * s.size, 1.1 * s.size, 1.6 * s.size, "joint");
};

const fixed: Kind = (s, draw) => brick(draw, s, s.points[0], 0.9 * s.size, 0.9 * s.size, 0.9 * s.size, "joint");

const rod: Kind = (s, draw) => {
  const { a, along, length } = span(s);
  bar(draw, "cylinder", a, along, length, 0.2 * s.size, "steel");
  for (const point of s.points) ball(draw, point, 0.36 * s.size, "joint");
};

function coil(s: Situation, draw: Draw, radius: number): void {
  const { a, along, length } = span(s);
  const stub = Math.min(0.12 * length, 1.2 * s.size);
  bar(draw, "cylinder", a, along, stub, 0.14 * s.size, "steel");
  bar(draw, "cylinder", plus(a, along, length - stub), along, stub, 0.14 * s.size, "steel");
  bar(draw, "coil", plus(a, along, stub), along, Math.max(length - 2 * stub, 1e-9), radius, "force");
}

function barrel(s: Situation, draw: Draw, radius: number, colour: Tint): void {
  const { a, along, length } = span(s);
  bar(draw, "cylinder", a, along, length, 0.32 * radius, "steel");
  bar(draw, "cylinder", plus(a, along, 0.1 * length), along, 0.5 * length, radius, colour);
  for (const point of [a, plus(a, along, length)]) ball(draw, point, 0.5 * radius, "steel");
}

const damper: Kind = (s, draw) => barrel(s, draw, 0.55 * s.size, "dark");
const actuator: Kind = (s, draw) => barrel(s, draw, 0.7 * s.size, "accent");

const spring: Kind = (s, draw) => {
  if (span(s).length < 0.2 * s.size) ring(draw, s, 0.8 * s.size, 0.6 * s.size, "force");
  else coil(s, draw, 0.7 * s.size);
};

const both: Kind = (s, draw) => {
  if (span(s).length < 0.2 * s.size) {
    bushing(s, draw);
    return;
  }
  barrel(s, draw, 0.36 * s.size, "dark");
  coil(s, draw, 0.8 * s.size);
};

const bushing: Kind = (s, draw) => {
  pin(draw, s, 0.34 * s.size, 1.6 * s.size, "steel");
  ring(draw, s, 0.75 * s.size, 1.8 * s.size, "dark");
};

const cable: Kind = (s, draw) => {
  for (let i = 0; i + 1 < s.points.length; i++) {
    const along = s.points[i + 1].clone().sub(s.points[i]);
    const length = along.length();
    if (length > 0) bar(draw, "cylinder", s.points[i], along.multiplyScalar(1 / length), length, 0.14 * s.size, "cable");
    if (i > 0) ball(draw, s.points[i], 0.3 * s.size, "steel");
  }
};

const gear: Kind = (s, draw) => {
  // two markers per coupled angle: wheels turn about the first one
  const centres = s.points.length >= 4 ? [s.points[0], s.points[2]] : s.points.slice(0, 2);
  for (const point of centres) {
    draw("gear", point, times(s.across, 1.3 * s.size), times(s.third, 1.3 * s.size), times(s.axis, 0.5 * s.size), "joint");
  }
};

const motor: Kind = (s, draw) => {
  pin(draw, s, 0.75 * s.size, 1.5 * s.size, "accent");
  pin(draw, s, 0.25 * s.size, 2.8 * s.size, "steel");
  draw("turn", plus(s.points[0], s.axis, s.size), times(s.across, s.size), times(s.third, s.size), times(s.axis, s.size), "motion");
};

const ground: Kind = (s, draw) => {
  const x = normalTo(s.up), y = s.up.clone().cross(x), at = s.points[0];
  draw("pyramid", at, times(x, 0.9 * s.size), times(y, 0.9 * s.size), times(s.up, 1.1 * s.size), "ground");
  draw("box", plus(at, s.up, -1.2 * s.size), times(x, 2.4 * s.size), times(y, 2.4 * s.size), times(s.up, 0.22 * s.size), "ground");
};

const gauge: Kind = (s, draw) => brick(draw, s, s.points[0], 0.45 * s.size, 0.1 * s.size, 1.1 * s.size, "sensor");

const rosette: Kind = (s, draw) => {
  for (const angle of [0, Math.PI / 4, Math.PI / 2]) {
    const axis = plus(times(s.axis, Math.cos(angle)), s.across, Math.sin(angle));
    const across = axis.clone().cross(s.third);
    draw("box", plus(s.points[0], axis, 0.6 * s.size), times(across, 0.3 * s.size), times(s.third, 0.1 * s.size), times(axis, 0.9 * s.size), "sensor");
  }
};

/** Straight arrow; moments have two heads. */
export function arrow(draw: Draw, from: THREE.Vector3, along: THREE.Vector3, length: number, radius: number, colour: Tint, heads = 1): void {
  const head = Math.min(4.4 * radius, 0.45 * length);
  bar(draw, "cylinder", from, along, Math.max(length - head, 1e-12), radius, colour);
  for (let i = 0; i < heads; i++) bar(draw, "cone", plus(from, along, length - head * (1 + 0.6 * i)), along, head, 2.3 * radius, colour);
}

const force: Kind = (s, draw) => arrow(draw, s.points[0], s.axis, 5 * s.size, 0.2 * s.size, "force");

const moment: Kind = (s, draw) => {
  arrow(draw, s.points[0], s.axis, 4 * s.size, 0.18 * s.size, "moment", 2);
  draw("turn", plus(s.points[0], s.axis, 0.8 * s.size), times(s.across, 1.2 * s.size), times(s.third, 1.2 * s.size), times(s.axis, 1.2 * s.size), "moment");
};

const contact: Kind = (s, draw) =>
  draw("octahedron", s.points[0], times(s.across, 0.6 * s.size), times(s.third, 0.6 * s.size), times(s.axis, 0.6 * s.size), "force");

const mass: Kind = (s, draw) => ball(draw, s.points[0], 0.8 * s.size, "dark");

const dot: Kind = (s, draw) => {
  for (const point of s.points) ball(draw, point, 0.4 * s.size, "joint");
};

const rail: Kind = (s, draw) => {
  brick(draw, s, s.points[0], 0.3 * s.size, 0.3 * s.size, 4 * s.size, "steel");
  ball(draw, s.points[0], 0.6 * s.size, "joint");
};

const plane: Kind = (s, draw) => {
  brick(draw, s, s.points[0], 3 * s.size, 3 * s.size, 0.14 * s.size, "steel");
  brick(draw, s, plus(s.points[0], s.axis, 0.3 * s.size), 1.1 * s.size, 1.1 * s.size, 0.45 * s.size, "joint");
};

const directions: Kind = (s, draw) => {
  ring(draw, s, 0.6 * s.size, 0.5 * s.size, "joint");
  pin(draw, s, 0.12 * s.size, 2 * s.size, "steel");
};

const torsion: Kind = (s, draw) => {
  pin(draw, s, 0.16 * s.size, 2.4 * s.size, "steel");
  bar(draw, "coil", plus(s.points[0], s.axis, -0.7 * s.size), s.axis, 1.4 * s.size, 0.6 * s.size, "force");
};

/** Equal loads at many points. */
const many: Kind = (s, draw) => {
  for (const point of s.points) arrow(draw, point, s.axis, 2.4 * s.size, 0.1 * s.size, "force");
};

/** Moving load: a thin line along its path, an arrow at the first point. */
const moving: Kind = (s, draw) => {
  for (let i = 0; i + 1 < s.points.length; i++) {
    const along = s.points[i + 1].clone().sub(s.points[i]);
    const length = along.length();
    if (length > 0) bar(draw, "cylinder", s.points[i], along.multiplyScalar(1 / length), length, 0.06 * s.size, "force");
  }
};

const point: Kind = (s, draw) => ball(draw, s.points[0], 0.26 * s.size, "sensor");

/** Parts of a hydraulic cylinder along its line, m: the barrel from the first point, and the piston in it. */
export function cylinderParts(length: number, { closed, stroke }: { closed: number; stroke: number }): { barrel: number; piston: number } {
  const barrel = Math.min(Math.max(closed, 1e-9), length);
  const spare = Math.max(0, (barrel - stroke) / 2);
  return { barrel, piston: Math.max(0, Math.min(barrel, spare + length - closed)) };
}

/** Hydraulic cylinder to scale; the two draw functions have the colours of its chambers. */
export function hydraulicCylinder(s: Situation, draw: Draw, [piston, rod]: [Draw, Draw], sizes: Cylinder): void {
  const { a, along, length } = span(s);
  const { barrel, piston: at } = cylinderParts(length, sizes);
  const radius = 0.55 * sizes.bore;
  if (at > 0) bar(piston, "cylinder", a, along, at, radius, "steel");
  if (barrel > at) bar(rod, "cylinder", plus(a, along, at), along, barrel - at, radius, "steel");
  bar(draw, "cylinder", plus(a, along, at), along, Math.max(length - at, 1e-9), 0.5 * Math.max(sizes.rod, 0.2 * sizes.bore), "steel");
  bar(draw, "cylinder", plus(a, along, at - 0.05 * sizes.bore), along, 0.1 * sizes.bore, 1.04 * radius, "dark");
  for (const point of [a, plus(a, along, length)]) ball(draw, point, 0.4 * sizes.bore, "steel");
}

const GROUPS: [Kind, string[]][] = [
  [revolute, ["revolute", "hinge"]],
  [spherical, ["spherical"]],
  [universal, ["universal"]],
  [cylindrical, ["cylindrical", "screw"]],
  [prismatic, ["prismatic", "slide"]],
  [rail, ["point-on-line"]],
  [plane, ["planar", "point-on-plane", "rolling-disc", "rolling-wheel", "rail-wheel", "knife-edge"]],
  [directions, ["parallel-axes", "perpendicular", "constant-orientation"]],
  [fixed, ["fixed", "weld"]],
  [rod, ["rod"]],
  [spring, ["spring"]],
  [damper, ["damper"]],
  [both, ["spring-damper"]],
  [torsion, ["torsion-spring", "torsion-damper", "torsion-spring-damper"]],
  [actuator, ["actuator", "hydraulic-cylinder"]],
  [bushing, ["bushing"]],
  [cable, ["cable"]],
  [gear, ["gear", "rack", "coupling"]],
  [motor, ["drive", "motor"]],
  [ground, ["ground"]],
  [gauge, ["gauge", "bridge", "stress", "von-mises", "principal-stress"]],
  [rosette, ["rosette"]],
  [force, ["force"]],
  [moment, ["moment"]],
  [many, ["line"]],
  [moving, ["moving-load"]],
  [contact, ["contact", "friction"]],
  [mass, ["point-mass"]],
];

const KINDS = new Map(GROUPS.flatMap(([kind, names]) => names.map((name) => [name, kind] as const)));

/** Shape of a kind in a group; dots for kinds without a symbol. */
export const kindOf = (name: string, group: string): Kind => KINDS.get(name) ?? (group === "sensor" ? point : dot);
