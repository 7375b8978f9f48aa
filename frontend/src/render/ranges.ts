/** Range of the colours: over the run, or at the displayed instant. */

import type * as THREE from "three";
import type { Source } from "../source/source";
import type { Store } from "../state";
import { Extremes } from "./extremes";
import type { Machine } from "./machine";

export class Ranges {
  private asked = "";
  private extremes = new Extremes();

  constructor(
    private store: Store,
    private machines: Machine[],
    private source: Source,
  ) {
    store.watch(["measure", "rangeMode", "runs"], () => void this.ask());
  }

  /** Request the range over the visible runs. */
  private async ask(): Promise<void> {
    const { measure, rangeMode, runs } = this.store.state;
    const asked = `${measure} ${rangeMode} ${runs.join()}`;
    this.asked = asked;
    if (measure === null || rangeMode !== "run") return;
    try {
      const found = await Promise.all(
        this.shown().map(({ run }) => run.scene.limits[measure] ?? this.source.extent(run.index, measure)),
      );
      if (this.asked === asked) this.set(found);
    } catch (error) {
      this.store.set({ message: (error as Error).message });
    }
  }

  private shown(): Machine[] {
    return this.machines.filter(({ run }) => this.store.state.runs[run.index] !== false);
  }

  private set(found: readonly (readonly [number, number])[]): void {
    const low = Math.min(...found.map(([x]) => x)), high = Math.max(...found.map(([, x]) => x));
    if (!Number.isFinite(low) || !Number.isFinite(high)) return;
    const { range } = this.store.state;
    if (range?.[0] !== low || range[1] !== high) this.store.set({ range: [low, high] });
  }

  /** Update the range of this instant before a picture, if selected. */
  update(renderer: THREE.WebGLRenderer): void {
    const { measure, rangeMode } = this.store.state;
    if (measure === null || rangeMode !== "instant") return;
    const bodies = this.shown().flatMap((machine) => machine.bodies.filter((body) => body.group.visible && body.knows));
    const found = this.extremes.find(renderer, bodies.map((body) => body.probe()));
    if (found) this.set([found]);
  }
}
