/** Meaning of clicks, drags and hovering: selection, probing and tools. */

import type { Vec3 } from "../protocol";
import type { Store } from "../state";
import type { Gestures } from "./controls";
import type { Hit, View } from "./view";

export interface Click {
  x: number;
  y: number;
  hit: Hit | null;
  event: PointerEvent;
}

export interface Drag {
  phase: "start" | "move" | "end";
  hit: Hit;
  /** World point under the mouse in the plane through the hit, perpendicular to the view. */
  point: Vec3;
}

export class Mouse implements Gestures {
  private clicks = new Set<(click: Click) => void>();
  private drags = new Set<(drag: Drag) => void>();
  private dragged: Hit | null = null;
  private resting: [number, number] | null = null;

  constructor(
    private view: View,
    private store: Store,
  ) {}

  onClick(call: (click: Click) => void): () => void {
    this.clicks.add(call);
    return () => this.clicks.delete(call);
  }

  onDrag(call: (drag: Drag) => void): () => void {
    this.drags.add(call);
    return () => this.drags.delete(call);
  }

  click(x: number, y: number, event: PointerEvent): void {
    const hit = this.view.pick(x, y);
    if (this.store.state.tool === "select") {
      this.store.set({ selection: hit && hit.body >= 0 ? { run: hit.run, body: hit.body, vertex: hit.vertex } : null });
    }
    for (const call of [...this.clicks]) call({ x, y, hit, event });
  }

  double(x: number, y: number): void {
    const hit = this.view.pick(x, y);
    if (hit) this.view.focus(hit.position);
  }

  hover(x: number, y: number): void {
    const waits = this.resting !== null;
    this.resting = [x, y];
    if (waits) return;
    // at most one query per picture
    requestAnimationFrame(() => {
      if (!this.resting) return;
      const [px, py] = this.resting;
      this.resting = null;
      const hit = this.store.state.playing ? null : this.view.pick(px, py);
      const { hover } = this.store.state;
      if (hit?.run === hover?.run && hit?.body === hover?.body && hit?.vertex === hover?.vertex) return;
      this.store.set({ hover: hit && hit.body >= 0 ? { run: hit.run, body: hit.body, vertex: hit.vertex } : null });
    });
  }

  leave(): void {
    this.resting = null;
    this.store.set({ hover: null });
  }

  grab(x: number, y: number): boolean {
    if (this.store.state.tool !== "pull") return false;
    this.dragged = this.view.pick(x, y);
    if (!this.dragged || this.dragged.body < 0) {
      this.dragged = null;
      return false;
    }
    this.pass("start", x, y);
    return true;
  }

  drag(phase: "move" | "end", x: number, y: number): void {
    this.pass(phase, x, y);
    if (phase === "end") this.dragged = null;
  }

  private pass(phase: Drag["phase"], x: number, y: number): void {
    if (!this.dragged) return;
    const depth = this.view.at(this.dragged.position)?.[2] ?? 0.5;
    const drag = { phase, hit: this.dragged, point: this.view.unproject(x, y, depth) };
    for (const call of [...this.drags]) call(drag);
  }
}
