/** Overlay of several runs: visibility and offset. */

import { unlike } from "../format/compare";
import { quantity } from "../format/units";
import type { Vec3 } from "../protocol";
import { choice, h, hint, section, slider } from "./dom";
import type { Kit } from "./kit";

export function mountCompare(kit: Kit): void {
  const { app } = kit;
  const { store, runs } = app;
  if (runs.length < 2) return;
  const warnings = runs.slice(1).flatMap(({ scene, title }) => unlike(runs[0].scene, scene, [runs[0].title, title]) || []);
  for (const warning of warnings) kit.say(warning, "error");
  const list = h("div", "rows");
  runs.forEach((run, k) => {
    const input = h("input", { attrs: { type: "checkbox" } });
    input.addEventListener("change", () =>
      store.set({ runs: runs.map((_, i) => (i === k ? input.checked : (store.state.runs[i] ?? true))) }),
    );
    const dot = h("i", "dot");
    dot.style.background = app.view.runColours?.[k] ?? "var(--muted)";
    list.append(h("label", "row switch", h("span", "run", dot, run.title), input));
    store.watch(["runs"], (state) => (input.checked = state.runs[k] ?? true));
  });
  const [low, high] = runs[0].scene.box;
  const size = Math.hypot(...low.map((x, i) => high[i] - x));
  let axis = 1;
  const place = slider("Apart", { low: 0, high: 1.5 * size, step: size / 200 }, (v) => quantity(v, "m", 3), (v) => {
    const offset: Vec3 = [0, 0, 0];
    offset[axis] = v;
    store.set({ offset });
  });
  place.set(0);
  const along = choice<"0" | "1" | "2">("Along", [["0", "x"], ["1", "y"], ["2", "z"]], (value) => {
    const length = Math.max(...store.state.offset);
    axis = Number(value);
    along.set(value);
    const offset: Vec3 = [0, 0, 0];
    offset[axis] = length;
    store.set({ offset });
  });
  along.set("1");
  app.slots.right.append(
    section("Compare", true, hint("Runs are drawn over one another at the same time."), ...warnings.map((text) => h("p", { class: "hint wrong", text })), list, place.element, h("div", "field", h("span", { text: "Along" }), along.element)),
  );
}
