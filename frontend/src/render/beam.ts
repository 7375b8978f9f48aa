/** Exact beam in the picture: its rings are placed on the CPU. */

import * as THREE from "three";
import { turn } from "../math/rotation";
import { measure as evaluate } from "../math/tensor";
import type { RingPose } from "../motion/pose";
import { ringPoint, ringPose, ringStress } from "../motion/pose";
import type { Body, Rings } from "../protocol";
import { BodyView } from "./body";
import type { Shared } from "./shared";

const tensor = new Float64Array(6);
const point = new Float64Array(3);

export class BeamView extends BodyView {
  /** Corner normals in the axes of their section. */
  private normals: Float32Array | null = null;
  private poses: RingPose[];
  private rings: Rings;
  private known: Float32Array | null = null;
  private values: Float32Array | null = null;

  constructor(
    body: Body,
    shared: Shared,
    thing: number,
    /** Centre of the scene: origin of the single-precision corners. */
    private middle: THREE.Vector3,
    start: ArrayLike<number>,
  ) {
    super(placedAt(body, middle, start), shared, thing);
    this.rings = body.rings!;
    this.group.matrix.makeTranslation(middle.x, middle.y, middle.z);
    this.poses = Array.from({ length: this.rings.element.data.length }, () => ({ r: new Float64Array(3), Q: new Float64Array(9) }));
    if (this.drawn) {
      this.place(start);
      const world = this.drawn.getAttribute("normal").array as Float32Array;
      const source = this.drawn.getAttribute("source").array as Uint32Array;
      this.normals = new Float32Array(world.length);
      source.forEach((v, i) => {
        const { Q } = this.poses[this.rings.vertex_ring.data[v]];
        for (let k = 0; k < 3; k++) {
          this.normals![3 * i + k] = Q[k] * world[3 * i] + Q[3 + k] * world[3 * i + 1] + Q[6 + k] * world[3 * i + 2];
        }
      });
      this.known = new Float32Array(source.length);
      this.values = new Float32Array(source.length);
      for (const [name, array] of [["known", this.known], ["value", this.values]] as const) {
        const attribute = new THREE.BufferAttribute(array, 1);
        attribute.setUsage(THREE.DynamicDrawUsage);
        this.drawn.setAttribute(name, attribute);
      }
    }
  }

  private place(row: ArrayLike<number>): void {
    this.poses.forEach((pose, ring) => ringPose(this.rings, ring, row, pose));
  }

  override update(row: ArrayLike<number>, measure: string | null): void {
    super.update(row, measure);
    this.place(row);
    const { rings, corners, middle } = this;
    const count = rings.vertex_ring.data.length;
    for (let v = 0; v < count; v++) {
      ringPoint(rings, v, this.poses[rings.vertex_ring.data[v]], point);
      corners[3 * v] = point[0] - middle.x;
      corners[3 * v + 1] = point[1] - middle.y;
      corners[3 * v + 2] = point[2] - middle.z;
    }
    this.moved();
    if (!this.drawn || !this.normals) return;
    const source = this.drawn.getAttribute("source").array as Uint32Array;
    const x = this.drawn.getAttribute("position"), n = this.drawn.getAttribute("normal");
    const xs = x.array as Float32Array, ns = n.array as Float32Array;
    const stressed = measure !== null && measure !== "displacement" && rings.forces >= 0;
    for (let i = 0; i < source.length; i++) {
      const v = source[i];
      for (let k = 0; k < 3; k++) xs[3 * i + k] = corners[3 * v + k];
      const { Q } = this.poses[rings.vertex_ring.data[v]];
      turn(Q, this.normals[3 * i], this.normals[3 * i + 1], this.normals[3 * i + 2], point);
      for (let k = 0; k < 3; k++) ns[3 * i + k] = point[k];
      if (stressed) {
        const known = ringStress(rings, v, row, tensor);
        this.known![i] = known ? 1 : 0;
        this.values![i] = known ? evaluate(measure, tensor) : 0;
      }
    }
    x.needsUpdate = n.needsUpdate = true;
    if (stressed) this.drawn.getAttribute("known").needsUpdate = this.drawn.getAttribute("value").needsUpdate = true;
  }
}

/** Body with its corners at a row, relative to the centre of the scene. */
function placedAt(body: Body, middle: THREE.Vector3, row: ArrayLike<number>): Body {
  const rings = body.rings!;
  const data = new Float32Array(3 * rings.vertex_ring.data.length);
  let pose: RingPose | undefined, last = -1;
  rings.vertex_ring.data.forEach((ring, v) => {
    if (ring !== last) pose = ringPose(rings, ring, row);
    last = ring;
    ringPoint(rings, v, pose!, point);
    data.set([point[0] - middle.x, point[1] - middle.y, point[2] - middle.z], 3 * v);
  });
  return { ...body, place: -1, modes: 0, positions: { ...body.positions, data } };
}
