/** Distance between two clicked points, now and over time. */

import { quantity } from "../format/units";
import type { Vec3 } from "../protocol";
import type { Place } from "../state";
import { button, h } from "./dom";
import type { Kit } from "./kit";
import { placeName, tried } from "./kit";

const NS = "http://www.w3.org/2000/svg";

export function mountMeasure(kit: Kit): void {
  const { app, plots } = kit;
  const { store, view, source, slots, runs } = app;
  const svg = document.createElementNS(NS, "svg");
  svg.classList.add("measure-line");
  const line = document.createElementNS(NS, "line");
  svg.append(line);
  const label = h("div", "measure-label takes");
  const text = h("span");
  label.append(
    text,
    runs[0].scene.frames.data.length > 1 ? button("Plot the distance over time", () => void plot(), { icon: "chart" }) : "",
    button("Remove the distance", () => clear(), { icon: "close" }),
  );
  const help = h("div", { class: "tool-help", attrs: { role: "status" } });
  slots.overlay.append(svg, label, help);

  let places: Place[] = [];
  const clear = (): void => {
    places = [];
    draw();
  };
  const draw = (): void => {
    const measuring = store.state.tool === "measure";
    help.hidden = !measuring || places.length === 2;
    help.textContent = places.length ? "Click the second point." : "Click the first of two points.";
    const ends = places.map(({ run, body, vertex }) => view.project(run, body, vertex));
    const shown = ends.length > 0 && ends.every((end) => end !== null);
    svg.style.display = shown ? "" : "none";
    label.hidden = !shown || places.length < 2;
    if (!shown) return;
    const [a, b = a] = ends as [number, number, number][];
    const names = { x1: a[0], y1: a[1], x2: b[0], y2: b[1] };
    for (const [name, value] of Object.entries(names)) line.setAttribute(name, value.toFixed(1));
    if (places.length < 2) return;
    const [p, q] = places.map(({ run, body, vertex }) => view.position(run, body, vertex));
    text.textContent = quantity(Math.hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]), "m", 5);
    label.title = ["x", "y", "z"].map((axis, i) => `Δ${axis} ${quantity(q[i] - p[i], "m", 5)}`).join("\n");
    label.style.transform = `translate(${((a[0] + b[0]) / 2).toFixed(1)}px, ${((a[1] + b[1]) / 2).toFixed(1)}px)`;
  };
  const plot = async (): Promise<void> => {
    const answers = await tried(
      kit,
      Promise.all(places.map(({ run, body, vertex }) => source.history(run, body, vertex, ["x", "y", "z"], 20000))),
    );
    if (!answers) return;
    const [a, b] = answers;
    const n = a.time.data.length;
    const away = Float64Array.from(a.time.data, (time, i) =>
      Math.hypot(...([0, 1, 2].map((axis) => at(b, axis, time) - a.values.data[axis * n + i]) as Vec3)),
    );
    const [from, to] = places.map((place) => placeName(app, place));
    plots.add([{ id: `distance ${from} ${to}`, label: `Distance, ${from} to ${to}`, unit: "m", time: a.time.data, values: away }]);
  };
  view.onClick(({ hit }) => {
    // symbols have no vertices
    if (store.state.tool !== "measure" || !hit || hit.body < 0) return;
    const { run, body, vertex } = hit;
    places = places.length === 2 ? [{ run, body, vertex }] : [...places, { run, body, vertex }];
    draw();
  });
  store.watch(["tool"], ({ tool }) => {
    slots.stage.classList.toggle("measuring", tool === "measure");
    if (tool !== "measure") clear();
    draw();
  });
  view.onDraw(draw);
}

/** Value of a history at a time, linear between its instants. */
function at(history: { time: { data: Float64Array }; values: { data: Float64Array } }, k: number, time: number): number {
  const { data: times } = history.time;
  const { data } = history.values;
  const n = times.length;
  let i = 0;
  let high = n - 1;
  while (high - i > 1) {
    const middle = (i + high) >> 1;
    if (times[middle] <= time) i = middle;
    else high = middle;
  }
  const span = times[high] - times[i];
  const share = span > 0 ? (time - times[i]) / span : 0;
  return data[k * n + i] + share * (data[k * n + high] - data[k * n + i]);
}
