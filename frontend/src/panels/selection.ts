/** Selected place: its values, and commands for it. */

import { measure } from "../format/measures";
import { number, quantity, unitFor } from "../format/units";
import type { Probe } from "../protocol";
import type { Place } from "../state";
import { key } from "../state";
import { button, debounced, h, hint, press, section, select } from "./dom";
import type { Kit } from "./kit";
import { bodyOf, placeName, probed, tried } from "./kit";

const STRESSES = ["von-mises", "signed-von-mises", "principal-max", "principal-min", "s11", "s22", "s33", "s12", "s23", "s13"];

export function mountSelection(kit: Kit): void {
  const { app, plots } = kit;
  const { store, source } = app;
  const empty = hint(
    app.runs[0].scene.frames.data.length > 1
      ? "Click a point of a body: its numbers are shown here, and its stress and displacement over time below."
      : "Click a point of a body: its numbers are shown here.",
  );
  const name = h("div", "place-name");
  const figures = h("dl", "figures");
  const actions = h("div", "actions");
  const digits = source.exact ? null : hint("Numbers of this saved page have 5 digits.");
  const panel = section("Point", true, empty, name, figures, actions, digits);
  app.slots.right.append(panel);

  const timed = app.runs[0].scene.frames.data.length > 1;
  const more = select("Plot", [["", "Choose …"]], (value) => {
    const { selection } = store.state;
    if (selection && value) void plots.place(selection, value.split(" "));
    more.set("");
  });
  const trace = button("Path", () => toggleTrace(kit), { text: true });
  trace.title = "Draw the path of this point";
  const follow = button("Follow", () => {
    const { selection, follow: now } = store.state;
    const wanted = selection && key(selection.run, selection.body);
    store.set({ follow: now === wanted ? null : wanted });
  }, { text: true });
  follow.title = "The camera follows this body";
  const away = button("Deselect", () => store.set({ selection: null }), { text: true, key: "Esc" });
  actions.append(...(timed ? [more.element, trace] : []), follow, away);

  let asked = 0;
  const ask = debounced(60, async (place: Place, time: number) => {
    const number = ++asked;
    const found = await tried(kit, probed(app, place, time));
    if (found && number === asked) figures.replaceChildren(...lines(found));
  });
  let shown: Place | null = null;
  store.watch(["selection", "time", "traces", "follow", "playing"], ({ selection, time, traces, follow: now, playing }) => {
    for (const part of [name, figures, actions]) part.hidden = !selection;
    if (digits) digits.hidden = !selection;
    empty.hidden = !!selection;
    if (!selection) {
      if (shown) plots.unselect();
      shown = null;
      return;
    }
    press(trace, traces.some((place) => same(place, selection)));
    press(follow, now === key(selection.run, selection.body));
    if (shown !== selection) {
      name.textContent = placeName(app, selection);
      figures.replaceChildren();
      const body = bodyOf(app, selection);
      const known = [
        ...(body.stress || body.static || body.rings ? STRESSES : []),
        ...(body.shapes ? ["displacement", "ux", "uy", "uz"] : []),
        ...(body.damage ? ["damage"] : []),
      ].map((one) => [one, measure(one).label] as const);
      more.input.replaceChildren(
        ...[["", "Choose …"] as const, ...known, ["x y z", "Position x, y, z"] as const].map(([value, text]) =>
          h("option", { text, attrs: { value } }),
        ),
      );
      if (timed && !same(shown, selection)) void plots.place(selection, first(kit, selection), true);
      shown = selection;
    }
    // no requests while playing: the numbers change too fast to read
    if (!playing) ask(selection, time);
  });
}

/** Plots of a click: known ones of stress, displacement and damage; else the position. */
function first(kit: Kit, place: Place): string[] {
  const body = bodyOf(kit.app, place);
  const chosen = kit.app.store.state.measure;
  const stressed = body.stress || body.static || (body.rings && body.rings.forces >= 0);
  const known = [
    ...(stressed ? [chosen && STRESSES.includes(chosen) ? chosen : "von-mises"] : []),
    ...(body.shapes ? ["displacement"] : []),
    ...(body.damage ? ["damage"] : []),
  ];
  return known.length ? known : ["x", "y", "z"];
}

const same = (a: Place | null, b: Place): boolean =>
  a?.run === b.run && a.body === b.body && a.vertex === b.vertex;

export function toggleTrace(kit: Kit): void {
  const { store } = kit.app;
  const { selection, traces } = store.state;
  if (!selection) return;
  const rest = traces.filter((place) => !same(place, selection));
  store.set({ traces: rest.length < traces.length ? rest : [...traces, selection] });
}

function lines(found: Probe): HTMLElement[] {
  const rows: [string, string][] = [];
  if (found["von-mises"] !== null) rows.push(["Von Mises", quantity(found["von-mises"], "Pa", 5)]);
  if (found.principal) rows.push(["Principal", triple(found.principal, "Pa")]);
  if (found.stress) {
    rows.push(["σ 11 22 33", triple(found.stress.slice(0, 3), "Pa")], ["τ 12 23 13", triple(found.stress.slice(3), "Pa")]);
  }
  const shift = Math.hypot(...found.displacement);
  if (Number.isFinite(shift)) {
    rows.push(["Displacement", quantity(shift, "m", 5)]);
    if (shift > 0) rows.push(["u x y z", triple(found.displacement, "m")]);
  }
  rows.push(["Position", triple(found.position, "m", 5)]);
  if (found.damage !== null) rows.push(["Damage", quantity(found.damage, "1", 4)]);
  if (found.life !== null) rows.push(["Life", quantity(found.life, "s", 4)]);
  return rows.flatMap(([term, text]) => [h("dt", { text: term }), h("dd", { text })]);
}

/** Three values in the unit of the largest. */
function triple(values: readonly number[], unit: string, digits = 4): string {
  const largest = Math.max(...values.map(Math.abs));
  const { label, factor: scale } = unitFor(unit, largest);
  return `${values.map((v) => number(Math.abs(v) < 1e-12 * largest ? 0 : v * scale, digits)).join("  ")} ${label}`;
}
