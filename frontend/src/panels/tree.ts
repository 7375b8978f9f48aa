/** Tree of bodies, symbols and sensors: search, hide, isolate, make transparent, colour, follow. */

import { quantity } from "../format/units";
import type { Look } from "../state";
import { key } from "../state";
import { button, h, hint, press } from "./dom";
import type { Kit } from "./kit";

interface Row {
  element: HTMLElement;
  text: string;
}

const KINDS: Record<string, string> = {
  solid: "flexible",
  frame: "flexible",
  beam: "beam",
  rigid: "rigid",
  ground: "ground",
  mesh: "rigid",
  contact: "contact",
};

export function mountTree(kit: Kit): void {
  const { app } = kit;
  const search = h("input", {
    class: "search",
    attrs: { type: "search", placeholder: "Search bodies, joints, sensors", "aria-label": "Search the tree" },
  });
  const rows: Row[] = [];
  const list = h("div", { class: "tree", attrs: { tabindex: "-1" } });
  const none = hint("Nothing has this name.");
  none.hidden = true;

  app.runs.forEach((run, index) => {
    const name = app.runs.length > 1 ? run.title : "Bodies";
    list.append(group(name, run.scene.bodies.map((_, body) => bodyRow(kit, index, body, rows)), true));
  });
  const { symbols, sensors } = app.runs[0].scene;
  if (symbols.length) {
    const made = symbols.map((symbol) => {
      const element = h(
        "div",
        { class: "leaf", title: symbol.text },
        h("span", { class: "name", text: symbol.name }),
        h("span", { class: "kind", text: symbol.kind }),
      );
      rows.push({ element, text: `${symbol.name} ${symbol.kind}`.toLowerCase() });
      return element;
    });
    list.append(group("Joints and forces", made, symbols.length <= 12));
  }
  if (sensors.length) {
    const plotted = app.source.live || app.runs[0].scene.frames.data.length > 1;
    const made = sensors.map((sensor) => {
      const show = (): void => void kit.plots.sensor(sensor.name);
      const element = h(
        "div",
        { class: "leaf", title: sensor.description },
        plotted
          ? h("button", { class: "name link", text: sensor.name, attrs: { type: "button" }, on: { click: show } })
          : h("span", { class: "name", text: sensor.name }),
        h("span", { class: "kind", text: sensor.unit === "1" ? "" : sensor.unit }),
        plotted && button(`Plot ${sensor.name}`, show, { icon: "chart" }),
      );
      rows.push({ element, text: sensor.name.toLowerCase() });
      return element;
    });
    list.append(group("Sensors", made, true));
  }
  search.addEventListener("input", () => {
    const wanted = search.value.trim().toLowerCase();
    let found = 0;
    for (const { element, text } of rows) {
      element.hidden = !text.includes(wanted);
      if (!element.hidden) found++;
    }
    for (const part of list.querySelectorAll("details")) {
      part.hidden = !part.querySelector(".leaf:not([hidden])");
      if (wanted) part.open = true;
    }
    none.hidden = found > 0;
  });
  const all = button("Show all bodies", () => app.store.set({ looks: bare(app.store.state.looks), isolated: null }), {
    text: true,
    class: "wide",
  });
  app.store.watch(["looks", "isolated"], ({ looks, isolated }) => {
    all.hidden = !isolated && !Object.values(looks).some((look) => look.hidden || look.transparent);
  });
  app.slots.left.append(h("div", "panel-head", search), list, none, all);
}

/*Appearance without the visibility settings; colours remain. */
function bare(looks: Record<string, Look>): Record<string, Look> {
  return Object.fromEntries(
    Object.entries(looks).flatMap(([name, { colour }]) => (colour ? [[name, { colour }]] : [])),
  );
}

function group(title: string, items: HTMLElement[], open: boolean): HTMLElement {
  const made = h("details", "group", h("summary", {}, title, h("span", { class: "count", text: `${items.length}` })), ...items);
  made.open = open;
  return made;
}

function bodyRow(kit: Kit, run: number, index: number, rows: Row[]): HTMLElement {
  const { app } = kit;
  const body = app.runs[run].scene.bodies[index];
  const name = key(run, index);
  const change = (look: Look): void => {
    const { looks } = app.store.state;
    app.store.set({ looks: { ...looks, [name]: { ...looks[name], ...look } } });
  };
  const isolate = (): void =>
    app.store.set({ isolated: app.store.state.isolated === name ? null : name });
  const shown = button(`Hide ${body.name}`, () => change({ hidden: !app.store.state.looks[name]?.hidden }), { icon: "eye" });
  const ghost = button(
    `Make ${body.name} transparent`,
    () => change({ transparent: !app.store.state.looks[name]?.transparent }),
    { icon: "ghost" },
  );
  const alone = button(`Show only ${body.name}`, isolate, { icon: "target" });
  const colour = h("input", {
    class: "swatch",
    title: `Colour of ${body.name}`,
    attrs: { type: "color", "aria-label": `Colour of ${body.name}`, value: app.view.bodyColour(run, index) },
    on: { input: (event) => change({ colour: (event.target as HTMLInputElement).value }) },
  });
  const about = [body.about, body.mass === null ? "" : `mass ${massText(body.mass)}`].filter(Boolean).join("; ");
  const focus = h("button", {
    class: "name link",
    text: body.name,
    title: [about, "Click to turn about it, double click to show it alone."].filter(Boolean).join("\n"),
    attrs: { type: "button" },
    on: {
      click: () => app.view.focus(app.view.position(run, index, middle(body.positions.data))),
      dblclick: isolate,
    },
  });
  const element = h("div", "leaf", colour, focus, h("span", { class: "kind", text: KINDS[body.kind] ?? body.kind }), h("span", "acts", ghost, alone, shown));
  rows.push({ element, text: body.name.toLowerCase() });
  app.store.watch(["looks", "isolated", "selection", "runs"], ({ looks, isolated, selection }) => {
    const look = looks[name] ?? {};
    press(shown, !!look.hidden);
    press(ghost, !!look.transparent);
    press(alone, isolated === name);
    colour.value = app.view.bodyColour(run, index);
    element.classList.toggle("off", !!look.hidden || (isolated !== null && isolated !== name));
    element.classList.toggle("chosen", selection?.run === run && selection.body === index);
  });
  return element;
}

const massText = (mass: number): string => (mass < 0.1 ? `${quantity(mass * 1e3, "g", 3)}` : quantity(mass, "kg", 4));

/** Vertex nearest to the centre of a body. */
function middle(x: Float32Array): number {
  const mean = [0, 0, 0];
  for (let i = 0; i < x.length; i++) mean[i % 3] += (3 * x[i]) / x.length;
  let best = 0;
  let near = Infinity;
  for (let v = 0; v < x.length / 3; v++) {
    const away = Math.hypot(x[3 * v] - mean[0], x[3 * v + 1] - mean[1], x[3 * v + 2] - mean[2]);
    if (away < near) [near, best] = [away, v];
  }
  return best;
}
