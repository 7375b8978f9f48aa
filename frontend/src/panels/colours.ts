/** Settings of the colours: measure, range, map, bands, isolines. */

import { measure, oneSided } from "../format/measures";
import { typed } from "../format/range";
import { number, unitFor } from "../format/units";
import type { State } from "../state";
import { choice, h, hint, section, select, toggle } from "./dom";
import type { Kit } from "./kit";

export function mountColours(kit: Kit): void {
  const { app } = kit;
  const { store, view } = app;
  const { measures, what } = app.runs[0].scene;
  if (!measures.length) {
    app.slots.right.append(
      section("Colours", true, hint("No stress or displacement is known here: bodies have their own colours.")),
    );
    return;
  }
  const names = measures.map((name) => [name, measure(name).label] as const);
  const meaning = select("Colour by", [["", "Body"], ...names], (value) => {
    store.set({ measure: value || null, range: null, ...(store.state.rangeMode === "fixed" ? { rangeMode: "run" } : {}) });
  });
  const about = hint("");
  const timed = what === "run" || what === "live";
  const range = choice<State["rangeMode"]>(
    "Range",
    timed ? [["run", "Whole run"], ["instant", "This instant"], ["fixed", "Fixed"]] : [["run", "Whole"], ["instant", "Now"], ["fixed", "Fixed"]],
    (rangeMode) => store.set({ rangeMode }),
  );
  const low = h("input", { attrs: { type: "text", inputmode: "decimal", "aria-label": "Lowest value" } });
  const high = h("input", { attrs: { type: "text", inputmode: "decimal", "aria-label": "Highest value" } });
  const unitLabel = h("span", "unit");
  const error = h("p", { class: "hint wrong", attrs: { role: "alert" } });
  const fixed = h("div", "row fixed", low, h("span", { text: "to" }), high, unitLabel);
  let factor = 1;
  const apply = (): void => {
    const wanted = typed(low.value.replace("−", "-"), high.value.replace("−", "-"));
    error.textContent = typeof wanted === "string" ? wanted : "";
    if (typeof wanted !== "string") store.set({ range: [wanted[0] / factor, wanted[1] / factor] });
  };
  low.addEventListener("change", apply);
  high.addEventListener("change", apply);

  const map = select("Map", view.maps.map((name) => [name, name[0].toUpperCase() + name.slice(1)] as const), (name) =>
    store.set({ map: name }),
  );
  const bands = select(
    "Bands",
    [["0", "Smooth"], ["8", "8"], ["10", "10"], ["12", "12"], ["16", "16"], ["24", "24"]],
    (value) => store.set({ bands: Number(value) }),
  );
  const isolines = toggle("Isolines", (on) => store.set({ isolines: on }));
  const flat = toggle("No shading, exact colours", (on) => store.set({ flat: on }));
  const only = h("div", "rows", h("div", "field", h("span", { text: "Range" }), range.element), fixed, error, map.element, bands.element, isolines.element, flat.element);
  const panel = section("Colours", true, meaning.element, about, only);
  app.slots.right.append(panel);

  let mode: State["rangeMode"] | null = null;
  store.watch(["measure", "rangeMode", "range", "map", "bands", "isolines", "flat"], (state) => {
    const name = state.measure;
    meaning.set(name ?? "");
    about.textContent = name ? measure(name).about : "";
    about.hidden = !name;
    only.hidden = !name;
    range.set(state.rangeMode);
    fixed.hidden = error.hidden = state.rangeMode !== "fixed";
    map.set(state.map);
    bands.set(String(state.bands));
    isolines.set(state.isolines);
    flat.set(state.flat);
    if (name && state.range && (state.rangeMode !== "fixed" || mode !== "fixed" || !low.value)) {
      // typed numbers keep their unit until another range is chosen
      const unit = unitFor(measure(name).unit, Math.max(Math.abs(state.range[0]), Math.abs(state.range[1])));
      factor = unit.factor;
      unitLabel.textContent = unit.label;
      const plain = (value: number): string => number(value * factor, 4);
      [low.value, high.value] = [plain(oneSided(name) && state.range[0] < 0 ? 0 : state.range[0]), plain(state.range[1])];
    }
    mode = state.rangeMode;
  });
}
