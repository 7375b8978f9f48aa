/** Symbols of a run: joints, forces, sensors and supports, placed by a row. */

import * as THREE from "three";
import { matrix, product, turn } from "../../math/rotation";
import { sideAxes, sidePosition } from "../../motion/pose";
import type { Scene, Side, Symbol } from "../../protocol";
import type { State } from "../../state";
import { key } from "../../state";
import { raw } from "../appearance";
import type { Shared } from "../shared";
import { Batch } from "./batch";
import type { Shape } from "./glyphs";
import type { Draw, Situation, Tint } from "./kinds";
import { arrow, hydraulicCylinder, kindOf, normalTo } from "./kinds";
import type { Pressures } from "./pressures";
import { sizesOf } from "./sizes";
import type { Touch } from "./touches";
import { MOST_ARROWS } from "./touches";

const TINTS: Record<Tint, THREE.Color> = {
  joint: raw("#e0a33e"),
  accent: raw("#3f87c9"),
  force: raw("#d9594c"),
  steel: raw("#c3c9d1"),
  dark: raw("#5b6470"),
  ground: raw("#848c97"),
  sensor: raw("#8a5fc0"),
  cable: raw("#4c535c"),
  moment: raw("#9a5fc4"),
  motion: raw("#3fa66b"),
};

const TRIAD = [raw("#d64b45"), raw("#4da352"), raw("#4577d6")];

/** Arrow of a sensor at a world point. */
export interface Arrow {
  at: THREE.Vector3;
  value: THREE.Vector3;
  /** Length of the largest arrow of its kind, m, per unit of value. */
  scale: number;
  kind: "force" | "moment" | "velocity" | "acceleration";
  sensor: number;
}

const A = new Float64Array(9);
const B = new Float64Array(9);
const point = new Float64Array(3);

export class Symbols {
  readonly group = new THREE.Group();
  readonly picks: THREE.Object3D[] = [];
  private batches = new Map<Shape, Batch>();
  private capacity: number;
  private sizes: number[] | null = null;

  constructor(
    private scene: Scene,
    private shared: Shared,
    private middle: THREE.Vector3,
    private radius: number,
    private firstThing: number,
    private run: number,
    private pressures: Pressures,
  ) {
    this.group.matrixAutoUpdate = false;
    this.group.matrix.makeTranslation(middle.x, middle.y, middle.z);
    const points = scene.symbols.reduce((n, symbol) => n + symbol.sides.length, 0);
    const touches = scene.touches === null ? 0 : MOST_ARROWS;
    const cylinders = scene.symbols.filter(({ cylinder }) => cylinder).length;
    this.capacity = touches + 8 * cylinders + 4 * (points + scene.symbols.length) + 6 * scene.markers.length + 4 * scene.sensors.length + 16;
  }

  /** Place all symbols; `shown` determines the hidden ones. */
  update(row: ArrayLike<number>, state: Readonly<State>, arrows: Arrow[], touches: { shown: Touch[]; scale: number } | null): void {
    for (const batch of this.batches.values()) batch.begin();
    const gone = this.gone(state);
    const away = (sides: readonly Side[]): boolean => gone !== null && sides.every(({ place }) => gone(place));
    const up = new THREE.Vector3(...this.scene.up).normalize();
    this.sizes ??= sizesOf(this.scene, row, this.radius);
    const sizes = this.sizes;
    this.scene.symbols.forEach((symbol, i) => {
      if (!state.symbols[symbol.group] || (symbol.sides.length && away(symbol.sides))) return;
      const at = this.situation(symbol, row, state.amplification, up, sizes[i]), tag = this.firstThing + i;
      if (symbol.cylinder) {
        const [piston, rod] = symbol.cylinder.pressures.map((name) => this.painter(tag, this.pressures.colour(name, state.time, state.map)));
        hydraulicCylinder(at, this.painter(tag), [piston, rod], symbol.cylinder);
      } else kindOf(symbol.kind, symbol.group)(at, this.painter(tag));
    });
    if (state.markers) this.markers(row, state, away);
    if (state.arrows) {
      for (const one of arrows) {
        if (away([this.scene.sensors[one.sensor].side!])) continue;
        const length = one.value.length() * one.scale * state.arrowScale;
        if (!(length > 1e-3 * this.radius)) continue;
        const draw = this.painter(NOTHING);
        const colour: Tint = one.kind === "force" ? "force" : one.kind === "moment" ? "moment" : "motion";
        const along = one.value.clone().normalize();
        arrow(draw, one.at.clone().sub(this.middle), along, length, 0.0065 * this.radius, colour, one.kind === "moment" ? 2 : 1);
      }
    }
    if (touches && state.touches && state.isolated === null) this.touches(touches.shown, touches.scale * state.arrowScale);
    for (const batch of this.batches.values()) batch.end();
  }

  /** Arrows of contact forces; their numbers follow those of the symbols. */
  private touches(shown: readonly Touch[], scale: number): void {
    shown.slice(0, MOST_ARROWS).forEach(({ at, force }, i) => {
      const length = force.length() * scale;
      if (!(length > 1e-3 * this.radius)) return;
      const draw = this.painter(this.firstThing + this.scene.symbols.length + i);
      arrow(draw, at.clone().sub(this.middle), force.clone().normalize(), length, 0.0065 * this.radius, "force");
    });
  }

  /** Whether symbols on the body at a place are hidden with it; null if nothing is hidden. */
  private gone(state: Readonly<State>): ((place: number) => boolean) | null {
    const { isolated, looks } = state;
    if (isolated === null && !Object.values(looks).some((look) => look.hidden)) return null;
    const seen = new Set<number>();
    this.scene.bodies.forEach((body, i) => {
      const name = key(this.run, i);
      if (isolated === null ? looks[name]?.hidden : isolated !== name) return;
      seen.add(body.place);
      for (const place of body.rings?.places.data ?? []) seen.add(place);
    });
    // ground symbols are hidden when a single body is shown
    if (isolated === null) seen.add(-1);
    else if (!this.scene.bodies.some((body, i) => body.place < 0 && isolated === key(this.run, i))) seen.delete(-1);
    const known = new Set(this.scene.bodies.flatMap((body) => [body.place, ...(body.rings?.places.data ?? [])]));
    return (place) => !seen.has(place) && (isolated !== null || known.has(place));
  }

  private situation(symbol: Symbol, row: ArrayLike<number>, s: number, up: THREE.Vector3, size: number): Situation {
    const points = symbol.sides.map((side) => this.local(sidePosition(side, row, s, point)));
    if (symbol.fixed) matrix([1, 0, 0, 0], 0, A);
    else sideAxes(symbol.sides[0], row, A);
    const [x, y, z] = symbol.axis ?? [0, 0, 1];
    turn(A, x, y, z, point);
    const axis = new THREE.Vector3(point[0], point[1], point[2]);
    if (axis.lengthSq() > 0) axis.normalize();
    else axis.copy(up);
    // cross axis fixed to the first body, so that its rotation is visible
    const first = Math.abs(x) < 0.7 * Math.hypot(x, y, z) ? 1 : 0;
    turn(A, first, 1 - first, 0, point);
    const across = new THREE.Vector3(point[0], point[1], point[2]);
    across.addScaledVector(axis, -across.dot(axis)).normalize();
    if (!(across.lengthSq() > 0.5)) across.copy(normalTo(axis));
    return { points, axis, across, third: axis.clone().cross(across), up, size };
  }

  private local(world: ArrayLike<number>): THREE.Vector3 {
    return new THREE.Vector3(world[0] - this.middle.x, world[1] - this.middle.y, world[2] - this.middle.z);
  }

  private markers(row: ArrayLike<number>, state: Readonly<State>, away: (sides: readonly Side[]) => boolean): void {
    const size = 0.07 * this.radius;
    for (const { side } of this.scene.markers) {
      if (away([side])) continue;
      const at = this.local(sidePosition(side, row, state.amplification, point));
      product(sideAxes(side, row, A), matrix(side.frame), B);
      for (let k = 0; k < 3; k++) {
        const along = new THREE.Vector3(B[k], B[3 + k], B[6 + k]);
        arrow(this.painter(NOTHING, TRIAD[k]), at, along, size, 0.04 * size, "steel");
      }
    }
  }

  private painter(tag: number, fixed?: THREE.Color): Draw {
    return (shape, origin, x, y, z, tint) => {
      placed.makeBasis(x, y, z).setPosition(origin);
      this.batch(shape).add(placed, fixed ?? TINTS[tint], tag);
    };
  }

  dispose(): void {
    for (const batch of this.batches.values()) batch.dispose();
  }

  private batch(shape: Shape): Batch {
    let batch = this.batches.get(shape);
    if (!batch) {
      batch = new Batch(shape, this.shared, this.capacity);
      this.batches.set(shape, batch);
      this.group.add(batch.solid, batch.hidden);
      batch.pick.matrixWorldAutoUpdate = false;
      batch.pick.matrixWorld = this.group.matrixWorld;
      this.picks.push(batch.pick);
    }
    return batch;
  }
}

/** Tag of objects outside the picking picture. */
export const NOTHING = 0xfffffffe;

const placed = new THREE.Matrix4();
