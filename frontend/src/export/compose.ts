/** Legend, title and time on an exported picture. */

import type { App } from "../app";
import { clock } from "../format/units";
import type { LegendLook } from "../panels/legend";

export interface Dress {
  legend: LegendLook | null;
  title: string;
  /*Whether the background is dark, so that text must be light. */
  dark: boolean;
  /** Ends of the axes in the corner, CSS pixels from the lower left corner. */
  ends: readonly (readonly [number, number])[];
}

/** Text at the foot: title, and the time or the mode. */
export function caption(app: App): string {
  const { scene, title } = app.runs[0];
  const { time, mode } = app.store.state;
  const chosen = scene.modes?.[mode];
  if (chosen) return `${title}, ${chosen.label}, ${chosen.frequency.toPrecision(4)} Hz`;
  return scene.frames.data.length > 1 ? `${title}, t = ${clock(time, 0.001)} s` : title;
}

/** Draw legend and caption on a canvas of height h, `k` picture pixels per CSS pixel. */
export function dress(ctx: CanvasRenderingContext2D, h: number, k: number, what: Dress): void {
  const ink = what.dark ? "#e6e9ee" : "#1d232b";
  const muted = what.dark ? "#b4bcc7" : "#4e5761";
  const face = getComputedStyle(document.body).fontFamily;
  ctx.save();
  ctx.textBaseline = "middle";
  ctx.fillStyle = muted;
  ctx.font = `${12 * k}px ${face}`;
  const axes = Math.max(0, ...what.ends.map(([x]) => x));
  if (what.title) ctx.fillText(what.title, (axes + 16) * k, h - 18 * k);
  ctx.textAlign = "center";
  what.ends.forEach(([x, y], i) => ctx.fillText("xyz"[i], x * k, h - y * k));
  ctx.textAlign = "left";
  const { legend } = what;
  if (legend) {
    const [x, top, width] = [16 * k, 48 * k, 16 * k];
    const height = Math.min(220 * k, h - 110 * k);
    ctx.fillStyle = ink;
    ctx.font = `600 ${13 * k}px ${face}`;
    ctx.fillText(`${legend.title}${legend.unit ? `, ${legend.unit}` : ""}`, x, 24 * k);
    const n = legend.shades.length;
    legend.shades.forEach((shade, i) => {
      ctx.fillStyle = shade;
      ctx.fillRect(x, top + height * (1 - (i + 1) / n), width, height / n + 0.6);
    });
    ctx.fillStyle = ink;
    ctx.font = `${12 * k}px ${face}`;
    for (const { share, text } of legend.marks) {
      const y = top + height * (1 - share);
      ctx.fillRect(x + width, y - k / 2, 4 * k, k);
      ctx.fillText(text, x + width + 8 * k, y);
    }
    if (legend.note) {
      ctx.fillStyle = muted;
      ctx.font = `${11 * k}px ${face}`;
      ctx.fillText(legend.note, x, top + height + 18 * k);
    }
  }
  ctx.restore();
}
