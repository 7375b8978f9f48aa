/** Legend over the picture: colours with round numbers in a readable unit. */

import { measure } from "../format/measures";
import { limit, ticks } from "../format/range";
import type { Unit } from "../format/units";
import { mark, number, unitFor } from "../format/units";
import type { App } from "../app";
import { h } from "./dom";
import type { Kit } from "./kit";

const SHADES = 128;

export interface LegendLook {
  title: string;
  unit: string;
  /** Height share from below, 0 to 1, and its label. */
  marks: { share: number; text: string }[];
  /** CSS colours from bottom to top. */
  shades: string[];
  note: string;
}

/** Content of the legend; null without a measure. */
export function legendLook(app: App): LegendLook | null {
  const { measure: name, range, rangeMode, map, bands, amplification } = app.store.state;
  if (!name || !range) return null;
  const known = measure(name);
  const unit = unitFor(known.unit, Math.max(Math.abs(range[0]), Math.abs(range[1])));
  const what = app.runs[0].scene.what;
  const parts = [
    what === "modes" ? "relative size only" : "",
    rangeMode === "instant" ? "range of this instant" : rangeMode === "fixed" ? "fixed range" : "",
    amplification !== 1 ? `deformation × ${number(amplification, 3)}` : "",
  ];
  return { title: known.label, unit: unit.label, ...scale(app, range, unit, map, bands || SHADES), note: parts.filter(Boolean).join(", ") };
}

/** Legend of the pressures of hydraulic cylinders, in bar; null without pressures. */
export function pressureLook(app: App): LegendLook | null {
  const { pressures } = app.view.machines[0];
  const [low, high] = pressures.range;
  if (!(high > low) || !app.store.state.symbols.force) return null;
  const unit = { label: "bar", factor: 1e-5 };
  return { title: "Pressure", unit: unit.label, ...scale(app, [low, high], unit, app.store.state.map, SHADES), note: "of chambers, gauge" };
}

/** Marks and shades of a range. */
function scale(app: App, [low, high]: readonly [number, number], unit: Unit, map: string, count: number): Pick<LegendLook, "marks" | "shades"> {
  const shades = app.view.ramp(map, count).map(([r, g, b]) => `rgb(${r} ${g} ${b})`);
  const span = high - low;
  const values =
    span > 0
      ? [low, ...ticks(low * unit.factor, high * unit.factor, 5).map((v) => v / unit.factor), high]
      : [low];
  const marks: { share: number; text: string }[] = [];
  for (const [i, value] of values.entries()) {
    const share = span > 0 ? (value - low) / span : 0;
    const end = i === 0 || i === values.length - 1;
    // leave out round numbers that would overlap the ends
    if (!end && (share < 0.08 || share > 0.92)) continue;
    marks.push({ share, text: end ? limit(value * unit.factor, span * unit.factor) : mark(value * unit.factor) });
  }
  return { marks, shades };
}

export function mountLegend(kit: Kit): void {
  const { app } = kit;
  const show = legend(app);
  app.store.watch(["measure", "range", "rangeMode", "map", "bands", "amplification"], () => show(legendLook(app)));
  if (!app.view.machines[0].pressures.wanted.length) return;
  const oil = legend(app, "oil");
  app.view.onDraw(() => oil(pressureLook(app)));
}

/** Add a legend to the picture; returns the function that shows a look in it. */
function legend(app: App, name = ""): (look: LegendLook | null) => void {
  const title = h("div", "title");
  const bar = h("div", "bar");
  const marks = h("div", "marks");
  const note = h("div", "note");
  const element = h(
    "div",
    { class: `legend ${name}`.trim(), attrs: { role: "img" } },
    title,
    h("div", "scale", bar, marks),
    note,
  );
  app.slots.overlay.append(element);
  let drawn = "";
  return (look) => {
    element.hidden = !look;
    if (!look) return;
    const state = JSON.stringify(look);
    if (state === drawn) return;
    drawn = state;
    title.replaceChildren(look.title, h("span", { class: "unit", text: look.unit }));
    const n = look.shades.length;
    const stops = look.shades.map((shade, i) => `${shade} ${(100 * i) / n}% ${(100 * (i + 1)) / n}%`);
    bar.style.background = `linear-gradient(to top, ${stops.join(", ")})`;
    marks.replaceChildren(
      ...look.marks.map(({ share, text }) => {
        const mark = h("span", { text });
        mark.style.bottom = `${100 * share}%`;
        return mark;
      }),
    );
    note.textContent = look.note;
    note.hidden = !look.note;
    const ends = [look.marks[0].text, look.marks[look.marks.length - 1].text];
    element.setAttribute("aria-label", `${look.title} from ${ends[0]} to ${ends[1]} ${look.unit}`);
  };
}
