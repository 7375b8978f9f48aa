/** Positions of body points, and stress, from a row in double precision. */

import { exponential, logarithm, matrix, product, transposedProduct, turn } from "../math/rotation";
import type { Matrix } from "../math/rotation";
import type { Block, Body, Rings, Side } from "../protocol";
import { half } from "../protocol";

type Row = ArrayLike<number>;
type Point = Float64Array | number[];

let halves: Float32Array | null = null;

/** Value of entry `i` of a block, half floats as numbers. */
export function entry(block: Block, i: number): number {
  if (block.type !== "f2") return block.data[i];
  halves ??= Float32Array.from({ length: 65536 }, (_, bits) => half(bits));
  return halves[block.data[i]];
}

const A = new Float64Array(9);
const local = new Float64Array(3);

/** Deformation `sum phi_j p_j` at a vertex, body frame, m. */
export function displacement(body: Body, vertex: number, row: Row, out: Point = [0, 0, 0]): Point {
  out[0] = out[1] = out[2] = 0;
  if (!body.shapes || body.place < 0) return out;
  const nv = body.shapes.shape[1];
  for (let j = 0; j < body.modes; j++) {
    const p = row[body.place + 7 + j] * (body.shape_scale?.[j] ?? 1);
    if (p === 0) continue;
    const at = 3 * (j * nv + vertex);
    for (let i = 0; i < 3; i++) out[i] += p * entry(body.shapes, at + i);
  }
  return out;
}

/** World position of a vertex, m; `s` scales the deformation. */
export function position(body: Body, vertex: number, row: Row, s = 1, out: Point = [0, 0, 0]): Point {
  if (body.rings) {
    const ring = body.rings.vertex_ring.data[vertex];
    return ringPoint(body.rings, vertex, ringPose(body.rings, ring, row), out);
  }
  displacement(body, vertex, row, local);
  const x = body.positions.data;
  return placed(body.place, row, x[3 * vertex] + s * local[0], x[3 * vertex + 1] + s * local[1], x[3 * vertex + 2] + s * local[2], out);
}

/** `R + A x` of the body at a row column; -1 is the world. */
export function placed(place: number, row: Row, x: number, y: number, z: number, out: Point): Point {
  if (place < 0) {
    out[0] = x;
    out[1] = y;
    out[2] = z;
    return out;
  }
  turn(matrix(row, place + 3, A), x, y, z, out);
  for (let i = 0; i < 3; i++) out[i] += row[place + i];
  return out;
}

/** World position of a symbol's point, m. */
export function sidePosition(side: Side, row: Row, s = 1, out: Point = [0, 0, 0]): Point {
  let [x, y, z] = side.u;
  if (side.phi && side.place >= 0) {
    const phi = side.phi.data, n = side.n;
    for (let j = 0; j < n; j++) {
      const p = s * row[side.place + 7 + j];
      x += phi[j] * p;
      y += phi[n + j] * p;
      z += phi[2 * n + j] * p;
    }
  }
  return placed(side.place, row, x, y, z, out);
}

/** Axes of the body of a side in the world. */
export function sideAxes(side: Side, row: Row, out: Matrix = new Float64Array(9)): Matrix {
  return side.place < 0 ? matrix([1, 0, 0, 0], 0, out) : matrix(row, side.place + 3, out);
}

/** Stress at a vertex, Pa; null where unknown. */
export function stress(body: Body, vertex: number, row: Row): Float64Array | null {
  if (body.known && !body.known.data[vertex]) return null;
  if (body.rings) return ringStress(body.rings, vertex, row);
  if (!body.stress && !body.static) return null;
  const out = new Float64Array(6);
  if (body.static) for (let i = 0; i < 6; i++) out[i] = body.static.data[6 * vertex + i];
  if (body.stress && body.place >= 0) {
    const nv = body.stress.shape[1];
    for (let j = 0; j < body.modes; j++) {
      const p = row[body.place + 7 + j] * (body.stress_scale?.[j] ?? 1);
      if (p === 0) continue;
      const at = 6 * (j * nv + vertex);
      for (let i = 0; i < 6; i++) out[i] += p * entry(body.stress, at + i);
    }
  }
  return out;
}

/** Origin and axes of the section at a ring. */
export interface RingPose {
  r: Float64Array;
  Q: Matrix;
}

/**
 * Pose of a ring: between the ends of its element the section turns evenly, the axis is a cubic
 * along the axes at both ends.
 */
export function ringPose(rings: Rings, ring: number, row: Row, out: RingPose = { r: new Float64Array(3), Q: new Float64Array(9) }): RingPose {
  const element = rings.element.data[ring], b = rings.share.data[ring], a = 1 - b;
  end(rings, element, 0, row, first);
  end(rings, element, 1, row, second);
  const phi = logarithm(transposedProduct(first.Q, second.Q, relative), spin);
  for (let i = 0; i < 3; i++) spin[i] = b * phi[i];
  product(first.Q, exponential(spin, relative), out.Q);
  const size = Math.hypot(second.r[0] - first.r[0], second.r[1] - first.r[1], second.r[2] - first.r[2]);
  const ra = a * a * (1 + 2 * b), rb = b * b * (1 + 2 * a), ta = a * a * b * size, tb = -a * b * b * size;
  for (let i = 0; i < 3; i++) {
    out.r[i] = ra * first.r[i] + rb * second.r[i] + ta * first.Q[3 * i] + tb * second.Q[3 * i];
  }
  return out;
}

const first: RingPose = { r: new Float64Array(3), Q: new Float64Array(9) };
const second: RingPose = { r: new Float64Array(3), Q: new Float64Array(9) };
const relative = new Float64Array(9);
const spin = new Float64Array(3);
const node = new Float64Array(9);
const fixed = new Float64Array(9);

/** Pose of an element's end: node pose times the end's pose on the node. */
function end(rings: Rings, element: number, side: 0 | 1, row: Row, out: RingPose): void {
  const place = rings.places.data[element + side];
  const at = 7 * (2 * element + side), x = rings.ends.data;
  matrix(row, place + 3, node);
  turn(node, x[at], x[at + 1], x[at + 2], out.r);
  for (let i = 0; i < 3; i++) out.r[i] += row[place + i];
  product(node, matrix(x, at + 3, fixed), out.Q);
}

/** Position of a corner of a ring with a known pose. */
export function ringPoint(rings: Rings, vertex: number, pose: RingPose, out: Point = [0, 0, 0]): Point {
  turn(pose.Q, 0, rings.yz.data[2 * vertex], rings.yz.data[2 * vertex + 1], out);
  for (let i = 0; i < 3; i++) out[i] += pose.r[i];
  return out;
}

/** Stress at a ring corner from the resultants, which are linear along the element. */
export function ringStress(rings: Rings, vertex: number, row: Row, out = new Float64Array(6)): Float64Array | null {
  if (rings.forces < 0) return null;
  const ring = rings.vertex_ring.data[vertex];
  const b = rings.share.data[ring];
  const at = rings.forces + 12 * rings.element.data[ring];
  const from = 36 * rings.corner.data[vertex], w = rings.rows.data;
  for (let i = 0; i < 6; i++) {
    let sum = 0;
    for (let j = 0; j < 6; j++) sum += w[from + 6 * i + j] * ((1 - b) * row[at + j] + b * row[at + 6 + j]);
    out[i] = sum;
  }
  return Number.isNaN(out[0]) ? null : out;
}
