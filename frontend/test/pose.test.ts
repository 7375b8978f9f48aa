import assert from "node:assert/strict";
import { test } from "node:test";
import { position, ringPose, sidePosition, stress } from "../src/motion/pose";
import type { Block, Body, Kind, Numbers, Rings, Side } from "../src/protocol";

function block<T extends Numbers>(data: T, shape: number[], type: Kind = "f8"): Block<T> {
  return { type, shape, data };
}

const close = (a: ArrayLike<number>, b: number[], tolerance = 1e-14): void => {
  for (let i = 0; i < b.length; i++) assert.ok(Math.abs(a[i] - b[i]) <= tolerance, `${i}: ${a[i]} is not ${b[i]}`);
};

const body: Body = {
  name: "arm", kind: "solid", place: 1, modes: 2,
  positions: block(new Float32Array([0, 0, 0, 2, 0, 0]), [2, 3], "f4"),
  triangles: null, lines: null, edges: null,
  // half floats: 1 is 0x3c00, -2 is 0xc000
  shapes: block(new Uint16Array([0, 0, 0, 0, 0x3c00, 0, 0, 0, 0, 0xc000, 0, 0]), [2, 2, 3], "f2"),
  shape_scale: [0.5, 0.25],
  stress: block(new Uint16Array([0, 0, 0, 0, 0, 0, 0x3c00, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xc000, 0, 0]), [2, 2, 6], "f2"),
  stress_scale: [1e6, 2e6],
  static: block(new Float32Array([0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0]), [2, 6], "f4"),
  known: block(new Uint8Array([0, 1]), [2], "u1"),
  nodes: null, damage: null, life: null, mass: null, about: "", rings: null, sections: null,
};
// one column before the body: R = (10, 20, 30), a quarter turn about z, p = (0.1, 0.2)
const row = [99, 10, 20, 30, Math.SQRT1_2, 0, 0, Math.SQRT1_2, 0.1, 0.2];

test("a vertex of a flexible body: R + A (x + s sum phi p)", () => {
  // deformation 0.1 * 0.5 * (0, 1, 0) + 0.2 * 0.25 * (-2, 0, 0) = (-0.1, 0.05, 0), then turned
  close(position(body, 1, row, 1), [10 - 0.05, 20 + 1.9, 30]);
  close(position(body, 1, row, 10), [10 - 0.5, 20 + 1, 30]);
  close(position(body, 1, row, 0), [10, 22, 30]);
});

test("stress: static and modal parts, unknown where it is not known", () => {
  close(stress(body, 1, row)!, [1e5, 5, 0, -8e5, 0, 0], 1e-9);
  assert.equal(stress(body, 0, row), null);
});

test("a point of a symbol moves with the modes of its body", () => {
  const phi = block(new Float64Array([0, -0.5, 0.5, 0, 0, 0]), [3, 2]);
  const side: Side = { place: 1, n: 2, u: [2, 0, 0], phi, frame: [1, 0, 0, 0] };
  close(sidePosition(side, row), [10 - 0.05, 20 + 1.9, 30]);
  close(sidePosition({ place: -1, n: 0, u: [1, 2, 3], phi: null, frame: [1, 0, 0, 0] }, row), [1, 2, 3]);
});

/** A beam of one element whose ends lie at its nodes, with axes along those of the nodes. */
const rings = (share: number): Rings => ({
  places: block(new Uint32Array([0, 7]), [2], "u4"),
  ends: block(new Float64Array([0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]), [1, 2, 7]),
  element: block(new Uint32Array([0]), [1], "u4"),
  share: block(new Float64Array([share]), [1]),
  vertex_ring: block(new Uint32Array([0]), [1], "u4"),
  yz: block(new Float32Array([0.25, 0.5]), [1, 2], "f4"),
  forces: 14,
  corner: block(new Uint16Array([0]), [1], "u2"),
  rows: block(Float64Array.from({ length: 36 }, (_, i) => (i === 0 ? 2 : i === 4 ? 10 : 0)), [1, 6, 6]),
  least: 0,
});

test("a ring of an exact beam: half of the turn, a cubic axis, linear resultants", () => {
  // from the origin along x to (3, 4, 0), the end turned by 90 degrees about z: chord 5
  const ends = [0, 0, 0, 1, 0, 0, 0, 3, 4, 0, Math.SQRT1_2, 0, 0, Math.SQRT1_2];
  const forces = [100, 0, 0, 0, 7, 0, 300, 0, 0, 0, 9, 0];
  const state = [...ends, ...forces];
  const pose = ringPose(rings(0.5), 0, state);
  // Hermite at 1/2: (ra + rb) / 2 + L (ta - tb) / 8
  close(pose.r, [1.5 + 5 / 8, 2 - 5 / 8, 0]);
  const c = Math.SQRT1_2;
  close(pose.Q, [c, -c, 0, c, c, 0, 0, 0, 1]);
  const beam: Body = { ...body, kind: "beam", place: -1, modes: 0, known: null, rings: rings(0.25) };
  // at 1/4 the section has turned by 22.5 degrees; its corner lies at y = 0.25, z = 0.5 of it
  const a = 0.75, b = 0.25;
  const x = b * b * (1 + 2 * a) * 3 + a * a * b * 5, y = b * b * (1 + 2 * a) * 4 - a * b * b * 5;
  const turned = Math.PI / 8;
  close(position(beam, 0, state), [x - 0.25 * Math.sin(turned), y + 0.25 * Math.cos(turned), 0.5]);
  // s11 = 2 N + 10 My with N = 150, My = 7.5 there
  close(stress(beam, 0, state)!, [2 * 150 + 10 * 7.5, 0, 0, 0, 0, 0], 1e-12);
});
