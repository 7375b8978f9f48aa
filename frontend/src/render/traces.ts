/** Paths of points: the whole path faint, the travelled part strong. */

import * as THREE from "three";
import { before } from "../motion/track";
import type { Source } from "../source/source";
import type { Place, State, Store } from "../state";
import { key } from "../state";
import { raw } from "./appearance";
import type { Machine } from "./machine";

const COLOURS = ["#d9594c", "#3f87c9", "#3fa66b", "#e0a33e", "#8a5fc0", "#3aa3a8"].map(raw);
const MOST = 4000; // largest number of points of a path

interface Path {
  place: Place;
  time: number[];
  whole: THREE.Line;
  travelled: THREE.Line;
}

const nameOf = ({ run, body, vertex }: Place): string => `${key(run, body)}:${vertex}`;

function line(geometry: THREE.BufferGeometry, colour: THREE.Color, opacity: number): THREE.Line {
  const material = new THREE.LineBasicMaterial({ color: colour, transparent: opacity < 1, opacity, toneMapped: false });
  const made = new THREE.Line(geometry, material);
  made.frustumCulled = false;
  return made;
}

export class Traces {
  readonly group = new THREE.Group();
  private paths = new Map<string, Path>();

  constructor(
    private store: Store,
    private machines: Machine[],
    private source: Source,
    private middle: THREE.Vector3,
    private redraw: () => void,
  ) {
    this.group.position.copy(middle);
    store.watch(["traces"], ({ traces }) => {
      const wanted = new Map(traces.map((place) => [nameOf(place), place]));
      for (const [name, path] of this.paths) if (!wanted.has(name)) this.remove(name, path);
      for (const [name, place] of wanted) if (!this.paths.has(name)) void this.add(name, place);
    });
    store.watch(["time"], ({ time }) => {
      if (source.live) for (const path of this.paths.values()) this.extend(path, time);
    });
  }

  private async add(name: string, place: Place): Promise<void> {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * MOST), 3));
    geometry.setDrawRange(0, 0);
    const travelled = new THREE.BufferGeometry();
    travelled.setAttribute("position", geometry.getAttribute("position"));
    const colour = COLOURS[this.paths.size % COLOURS.length];
    const path: Path = { place, time: [], whole: line(geometry, colour, 0.35), travelled: line(travelled, colour, 1) };
    this.paths.set(name, path);
    this.group.add(path.whole, path.travelled);
    if (this.source.live) return;
    try {
      const { run, body, vertex } = place;
      const { time, values } = await this.source.history(run, body, vertex, ["x", "y", "z"], MOST);
      const count = Math.min(MOST, time.data.length);
      for (let i = 0; i < count; i++) {
        this.set(path, i, [0, 1, 2].map((k) => values.data[k * time.data.length + i]));
        path.time.push(time.data[i]);
      }
      geometry.getAttribute("position").needsUpdate = true;
      geometry.setDrawRange(0, count);
      this.redraw();
    } catch (error) {
      this.store.set({ message: (error as Error).message });
    }
  }

  private set(path: Path, i: number, at: readonly number[]): void {
    const { x, y, z } = this.middle;
    path.whole.geometry.getAttribute("position").setXYZ(i, at[0] - x, at[1] - y, at[2] - z);
  }

  /** Add a point of a running machine; a full path drops its first half. */
  private extend(path: Path, time: number): void {
    const { run, body, vertex } = path.place;
    const last = path.time[path.time.length - 1];
    if (time === last) return;
    if (time < last) path.time = [];
    if (path.time.length === MOST) {
      const array = path.whole.geometry.getAttribute("position").array as Float32Array;
      array.copyWithin(0, 3 * (MOST / 2));
      path.time.splice(0, MOST / 2);
    }
    this.set(path, path.time.length, this.machines[run].position(body, vertex, 1));
    path.time.push(time);
    path.whole.geometry.getAttribute("position").needsUpdate = true;
    path.whole.geometry.setDrawRange(0, path.time.length);
  }

  update(state: Readonly<State>): void {
    for (const path of this.paths.values()) {
      const count = path.time.length && state.time >= path.time[0] ? before(path.time, state.time) + 1 : 0;
      path.travelled.geometry.setDrawRange(0, count);
      path.whole.visible = path.travelled.visible = state.runs[path.place.run] !== false;
      const shift = state.offset.map((x) => x * path.place.run);
      path.whole.position.set(shift[0], shift[1], shift[2]);
      path.travelled.position.copy(path.whole.position);
    }
  }

  private remove(name: string, path: Path): void {
    this.paths.delete(name);
    this.group.remove(path.whole, path.travelled);
    for (const { geometry, material } of [path.whole, path.travelled]) {
      geometry.dispose();
      (material as THREE.Material).dispose();
    }
  }
}
