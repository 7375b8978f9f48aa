/** Pressures of hydraulic cylinders as colours. */

import { before } from "../../motion/track";
import type { Scene } from "../../protocol";
import { raw } from "../appearance";
import { colourAt } from "../maps";
import type * as THREE from "three";

const UNKNOWN = raw("#8a9098");

export class Pressures {
  /** Smallest and largest pressure, Pa, with 0; equal until one is known. */
  readonly range: [number, number] = [0, 0];
  /** Names of the sensors of pressures. */
  readonly wanted: string[];
  private courses = new Map<string, { time: ArrayLike<number>; values: ArrayLike<number> }>();

  constructor(scene: Scene) {
    const names = scene.symbols.flatMap(({ cylinder }) => cylinder?.pressures ?? []);
    this.wanted = [...new Set(names.filter((name) => name))];
  }

  /** Set the history of a sensor. */
  take(name: string, time: ArrayLike<number>, values: ArrayLike<number>): void {
    if (!this.wanted.includes(name) || !time.length || !values) return;
    this.courses.set(name, { time, values });
    for (let i = 0; i < time.length; i++) {
      if (!Number.isFinite(values[i])) continue;
      this.range[0] = Math.min(this.range[0], values[i]);
      this.range[1] = Math.max(this.range[1], values[i]);
    }
  }

  /** Pressure at an instant, Pa; NaN where unknown. */
  at(name: string, time: number): number {
    const course = this.courses.get(name);
    if (!course) return NaN;
    const { time: times, values } = course;
    const i = before(times, time), j = Math.min(i + 1, times.length - 1);
    const span = times[j] - times[i];
    const f = span > 0 ? Math.max(0, Math.min(1, (time - times[i]) / span)) : 0;
    return values[i] + f * (values[j] - values[i]);
  }

  /** Colour of a pressure; grey where unknown. */
  colour(name: string, time: number, map: string): THREE.Color {
    const p = this.at(name, time), [low, high] = this.range;
    if (!Number.isFinite(p) || !(high > low)) return UNKNOWN;
    return raw(`rgb(${colourAt(map, (p - low) / (high - low)).map(Math.round).join(",")})`);
  }
}
