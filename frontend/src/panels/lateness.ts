/** Histogram of how late the steps of a running machine were. */

import { h } from "./dom";

/** Upper ends of the classes, ms; the last one has none. */
const EDGES = [0.1, 0.2, 0.5, 1, 2, 5, 10];

export class Lateness {
  private bars: HTMLElement[] = [];
  readonly element: HTMLElement;

  constructor() {
    const columns = [...EDGES, Infinity].map((edge, k) => {
      const bar = h("i");
      this.bars.push(bar);
      const text = Number.isFinite(edge) ? `${edge}` : `${EDGES[k - 1]}+`;
      return h("div", "column", h("div", "tall", bar), h("small", { text }));
    });
    this.element = h("div", { class: "lateness", attrs: { role: "img" } }, ...columns, h("small", { class: "unit", text: "ms" }));
  }

  /** Counts per class; logarithmic heights make a single late step visible. */
  show(counts: readonly number[]): void {
    const most = Math.max(1, ...counts);
    const total = counts.reduce((sum, count) => sum + count, 0);
    this.bars.forEach((bar, k) => {
      const count = counts[k] ?? 0;
      bar.style.height = `${count ? 8 + (92 * Math.log1p(count)) / Math.log1p(most) : 0}%`;
      bar.title = `${count} of ${total} steps`;
      bar.classList.toggle("wrong", k > 3 && count > 0);
    });
    const late = counts.slice(4).reduce((sum, count) => sum + count, 0);
    this.element.setAttribute("aria-label", `${late} of ${total} steps were more than 1 ms late`);
  }
}
