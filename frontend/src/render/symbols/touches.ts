/** Forces of contacts: arrows at the points at which bodies touch. */

import * as THREE from "three";
import { before } from "../../motion/track";
import type { Touches } from "../../protocol";
import type { Source } from "../../source/source";

const LONGEST = 0.45; // length of the arrow of the largest force, relative to the size of the scene
const PIECE = 32; // instants of one request
const KEPT = 64; // number of loaded pieces
const WIDTH = 13; // numbers of a point, see `Touches`

/** Largest number of arrows. */
export const MOST_ARROWS = 2000;

/** Point at which two bodies touch; forces act on the second one. */
export interface Touch {
  at: THREE.Vector3;
  force: THREE.Vector3;
  /** Contact, pair of bodies or shapes, and whether it sticks or slips. */
  text: string;
  gap: number;
  normal: number;
  friction: number;
  /** Largest pressure by Hertz; NaN for other laws. */
  pressure: number;
  approach: number;
  age: number;
}

export class ContactForces {
  /** Displayed points. */
  shown: Touch[] = [];
  private pieces = new Map<number, Touch[][]>();
  private asked = new Set<number>();
  private generation = 0;
  private failed = false;
  private largest: number;

  /**
   * `largest`: largest normal force of the run, 0 if unknown; `changed` is called when further points are there,
   * `say` with the reason why there are none.
   */
  constructor(
    largest: number,
    private radius: number,
    private run: number,
    private changed: () => void,
    private say: (message: string) => void,
  ) {
    this.largest = largest;
  }

  /** Length of an arrow, m per N; 0 if nothing has touched so far. */
  get scale(): number {
    return this.largest > 0 ? (LONGEST * this.radius) / this.largest : 0;
  }

  /** Take the points of the present instant of a running machine. */
  take(found: Touches): void {
    [this.shown] = unpack(found);
    for (const one of this.shown) this.largest = Math.max(this.largest, one.normal);
  }

  /** Drop all points: the frames are others. */
  forget(): void {
    this.generation++;
    this.pieces.clear();
    this.asked.clear();
  }

  /** Show the points of the frame at or before an instant, once they are loaded. */
  seek(source: Source, times: ArrayLike<number>, time: number): void {
    if (this.failed || !times.length) return;
    const i = before(times, time), number = Math.floor(i / PIECE);
    const piece = this.pieces.get(number);
    if (piece) {
      this.shown = piece[i - number * PIECE] ?? [];
      if (2 * (i % PIECE) > PIECE) this.load(source, times, number + 1);
    } else {
      this.shown = [];
      this.load(source, times, number);
    }
  }

  private load(source: Source, times: ArrayLike<number>, number: number): void {
    const first = number * PIECE, { generation } = this;
    if (first >= times.length || this.pieces.has(number) || this.asked.has(number)) return;
    this.asked.add(number);
    source.touches(this.run, first, Math.min(PIECE, times.length - first)).then(
      (found) => {
        if (generation !== this.generation) return;
        this.asked.delete(number);
        this.pieces.set(number, unpack(found));
        if (this.pieces.size > KEPT) this.pieces.delete(this.pieces.keys().next().value!);
        this.changed();
      },
      (error: unknown) => {
        this.failed = true;
        this.say((error as Error).message);
      },
    );
  }
}

/** Points of each instant. */
export function unpack({ counts, values, texts }: Touches): Touch[][] {
  let k = 0;
  return Array.from(counts.data, (count) =>
    Array.from({ length: count }, (): Touch => {
      const [x, y, z, fx, fy, fz, gap, normal, friction, pressure, approach, age, text] = values.data.subarray(WIDTH * k, WIDTH * ++k);
      return {
        at: new THREE.Vector3(x, y, z),
        force: new THREE.Vector3(fx, fy, fz),
        text: texts[text],
        gap,
        normal,
        friction,
        pressure,
        approach,
        age,
      };
    }),
  );
}
