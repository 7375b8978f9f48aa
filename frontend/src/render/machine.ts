/** Run in the picture: bodies and symbols, placed by one row. */

import * as THREE from "three";
import type { Run } from "../app";
import { position, stress, displacement } from "../motion/pose";
import { measure as evaluate } from "../math/tensor";
import type { Vec3 } from "../protocol";
import type { Source } from "../source/source";
import type { State } from "../state";
import type { Paint } from "./appearance";
import { appearance } from "./appearance";
import { BeamView } from "./beam";
import { BodyView } from "./body";
import { Neighbours } from "./picker";
import type { Shared } from "./shared";
import { Arrows } from "./symbols/arrows";
import { Pressures } from "./symbols/pressures";
import { Symbols } from "./symbols/symbols";
import { ContactForces, MOST_ARROWS } from "./symbols/touches";

const EMPTY = {
  time: { data: new Float64Array() },
  values: { data: new Float64Array(), shape: [0, 0] },
};

export class Machine {
  readonly group = new THREE.Group();
  readonly bodies: BodyView[];
  readonly symbols: Symbols;
  readonly arrows: Arrows;
  readonly pressures: Pressures;
  /** Forces of contacts; null for scenes without contacts. */
  readonly touches: ContactForces | null;
  row: ArrayLike<number>;
  private neighbours = new Map<number, Neighbours>();
  private stop: () => void = () => undefined;
  private frames: ArrayLike<number>;
  private shift: Vec3 = [0, 0, 0];

  constructor(
    readonly run: Run,
    shared: Shared,
    middle: THREE.Vector3,
    radius: number,
    readonly firstThing: number,
    private source: Source,
    changed: () => void,
    say: (message: string) => void,
  ) {
    this.row = run.scene.still.data;
    this.group.matrixAutoUpdate = false;
    this.bodies = run.scene.bodies.map((body, i) =>
      body.rings
        ? new BeamView(body, shared, firstThing + i, middle, this.row)
        : new BodyView(body, shared, firstThing + i),
    );
    for (const view of this.bodies) this.group.add(view.group);
    this.pressures = new Pressures(run.scene);
    this.symbols = new Symbols(run.scene, shared, middle, radius, firstThing + this.bodies.length, run.index, this.pressures);
    this.arrows = new Arrows(run.scene, radius);
    const { touches } = run.scene;
    this.touches = touches === null ? null : new ContactForces(touches, radius, run.index, changed, say);
    this.frames = run.track.times;
    this.group.add(this.symbols.group);
  }

  /** Request the histories of sensors shown as arrows. */
  async load(): Promise<void> {
    const { arrows, run, source } = this;
    if (source.live) {
      this.stop = source.onLive((live) => {
        if (live.touches) this.touches?.take(live.touches);
        let first = 0;
        for (const sensor of run.scene.sensors) {
          const values = [...live.sensors.data.subarray(first, first + sensor.components.length)];
          first += sensor.components.length;
          arrows.take(sensor.name, [live.time], values.map((value) => [value]));
          this.pressures.take(sensor.name, [live.time], values);
        }
      });
      return;
    }
    for (const name of this.pressures.wanted) {
      const { time, values } = await source.sensor(run.index, [name], 4000).catch(() => EMPTY);
      this.pressures.take(name, time.data, values.data);
    }
    for (const { name } of arrows.wanted) {
      // a sensor without numbers has no arrow; the plots show the reason
      const { time, values } = await source.sensor(run.index, [name], 4000).catch(() => EMPTY);
      const [count, length] = values.shape;
      arrows.take(name, time.data, Array.from({ length: count }, (_, k) => values.data.subarray(k * length, (k + 1) * length)));
    }
  }

  /** Place everything at an instant. */
  update(state: Readonly<State>): void {
    this.row = this.run.track.row(state.time);
    this.shift = state.offset.map((x) => x * this.run.index) as Vec3;
    this.group.matrix.makeTranslation(...this.shift);
    for (const view of this.bodies) if (view.group.visible) view.update(this.row, state.measure);
    if (state.touches && !this.source.live) this.seek(state.time);
    const arrows = state.arrows ? this.arrows.at(this.row, state.time, state.amplification) : [];
    this.symbols.update(this.row, state, arrows, this.touches);
  }

  /** Show the contact forces of an instant. */
  private seek(time: number): void {
    const { times } = this.run.track;
    if (times !== this.frames) this.touches?.forget();
    this.frames = times;
    this.touches?.seek(this.source, times, time);
  }

  /** Compute changed deformations and measures. */
  move(renderer: THREE.WebGLRenderer): void {
    if (!this.group.visible) return;
    for (const view of this.bodies) if (view.group.visible) view.moves?.draw(renderer);
  }

  /** GPU context lost. */
  forget(): void {
    for (const view of this.bodies) view.moves?.forget();
  }

  /** Number of objects in the picking picture. */
  get things(): number {
    return this.bodies.length + this.run.scene.symbols.length + (this.touches ? MOST_ARROWS : 0);
  }

  /** Objects for the picking picture. */
  picks(): THREE.Object3D[] {
    if (!this.group.visible) return [];
    const bodies = this.bodies.filter((view) => view.group.visible).map((view) => view.pickObject());
    return [...bodies, ...this.symbols.picks];
  }

  shadows(): THREE.Object3D[] {
    if (!this.group.visible) return [];
    return this.bodies.flatMap((view) => view.shadowObject() ?? []);
  }

  appear(state: Readonly<State>, paint: Paint): void {
    this.group.visible = state.runs[this.run.index] !== false;
    this.bodies.forEach((view, i) => view.appear(appearance(state, paint, this.run.index, i, this.run.scene.bodies[i])));
  }

  /** Present position of a vertex, world. */
  position(body: number, vertex: number, amplification: number): Vec3 {
    const at = position(this.run.scene.bodies[body], vertex, this.row, amplification);
    return [0, 1, 2].map((i) => at[i] + this.shift[i]) as Vec3;
  }

  /** Present measure at a vertex; NaN where unknown. */
  value(body: number, vertex: number, measure: string): number {
    const thing = this.run.scene.bodies[body];
    if (measure === "displacement") {
      const u = displacement(thing, vertex, this.row);
      return thing.rings ? NaN : Math.hypot(u[0], u[1], u[2]);
    }
    if (measure === "damage") return thing.damage?.data[vertex] ?? NaN;
    const s = stress(thing, vertex, this.row);
    return s ? evaluate(measure, s) : NaN;
  }

  /** Candidate vertices for the one under the mouse, from a vertex of the hit triangle. */
  candidates(body: number, vertex: number): Iterable<number> {
    const { triangles, positions } = this.run.scene.bodies[body];
    if (!triangles) return [vertex];
    let found = this.neighbours.get(body);
    if (!found) this.neighbours.set(body, (found = new Neighbours(triangles.data, positions.shape[0])));
    return found.of(vertex);
  }

  dispose(): void {
    this.stop();
    for (const view of this.bodies) view.dispose();
    this.symbols.dispose();
  }
}
