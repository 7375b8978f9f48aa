/** Curves over time above the time line: charts with a common time cursor, one for each unit. */

import type { Column } from "../format/csv";
import { difference } from "../format/compare";
import { csv } from "../format/csv";
import { measure } from "../format/measures";
import { reading } from "../format/units";
import type { App } from "../app";
import type { History } from "../protocol";
import type { Place } from "../state";
import { Chart } from "./chart";
import { button, download, fileName, h, paced, press } from "./dom";
import type { Say } from "./toasts";

export interface Curve extends Column {
  /** Identity of the curve, which prevents duplicates. */
  id: string;
  /** Run of the curve if several are compared. */
  run?: number;
  /** Common identity in several runs, for differences. */
  of?: string;
  /** Component index; dashes distinguish components where the run determines the colour. */
  component?: number;
  /** Whether the curve is a difference of two runs. */
  subtracted?: boolean;
  /** Whether the curve belongs to the selected place and is replaced by the next one. */
  fleeting?: boolean;
  /** Magnitude below which values of a stream are rounding error. */
  floor?: number;
}

const MOST = 4000;
const STREAM = 6000;

export class Plots {
  private curves: Curve[] = [];
  private charts = new Map<string, Chart>();
  private body = h("div", "charts");
  private element: HTMLElement;
  private keep: HTMLButtonElement;
  private subtract: HTMLButtonElement;
  private subtracts = false;
  private asked = 0;

  constructor(
    private app: App,
    private say: Say,
    private name: (place: Place) => string,
  ) {
    this.keep = button("Keep these curves", () => this.pin(), { text: true });
    this.subtract = button("Difference", () => {
      this.subtracts = !this.subtracts;
      press(this.subtract, this.subtracts);
      this.draw();
    }, { text: true });
    this.subtract.title = "Curves of the other runs minus that of the first";
    press(this.subtract, false);
    const table = button("CSV", () => this.save(), { icon: "save", text: true });
    table.title = "Save all curves as a table (CSV, SI units, full precision)";
    const close = button("Close all curves", () => this.clear(), { icon: "close" });
    const handle = h("div", {
      class: "handle",
      title: "Drag to change the height",
      attrs: { role: "separator", tabindex: "0", "aria-label": "Height of the curves", "aria-orientation": "horizontal" },
    });
    this.element = h(
      "section",
      { class: "plots", attrs: { "aria-label": "Curves over time" } },
      handle,
      h("div", "plots-head", h("strong", { text: "Curves" }), h("span", "grow"), this.subtract, this.keep, table, close),
      this.body,
    );
    this.element.hidden = true;
    app.slots.bottom.prepend(this.element);
    this.resizable(handle);
    new ResizeObserver(() => this.charts.forEach((chart) => chart.fit())).observe(this.body);
    let waiting = 0;
    app.store.watch(["time"], () => {
      // redraw curves of a running machine only after new values
      if (app.source.live || waiting) return;
      waiting = requestAnimationFrame(() => {
        waiting = 0;
        this.charts.forEach((chart) => chart.now(app.store.state.time));
      });
    });
    app.store.watch(["theme"], () => this.draw());
    new MutationObserver(() => this.draw()).observe(document.documentElement, {
      attributes: true,
      attributeFilter: ["data-theme"],
    });
    for (const { track } of app.runs) {
      track.onChange(() => {
        if (!app.source.live) this.charts.forEach((chart) => chart.span(app.player.start, app.player.end));
      });
    }
  }

  /** Whether there are curves. */
  get shown(): boolean {
    return this.curves.length > 0;
  }

  /** Plot all components of a sensor in every visible run that has it. */
  async sensor(name: string): Promise<void> {
    if (this.app.source.live) return this.stream(name);
    for (const { index, scene } of this.app.runs) {
      const known = scene.sensors.some((sensor) => sensor.name === name);
      if (!known || this.app.store.state.runs[index] === false) continue;
      const answer = await this.answered(this.app.source.sensor(index, [name], MOST));
      if (answer) this.add(this.named(answer, index, name));
    }
  }

  /** Plot values at a place; transient ones disappear with the next selection. */
  async place(place: Place, of: string[], fleeting = false): Promise<void> {
    const number = fleeting ? ++this.asked : this.asked;
    const { run, body, vertex } = place;
    const answer = await this.answered(this.app.source.history(run, body, vertex, of, MOST));
    if (!answer || (fleeting && number !== this.asked)) return;
    const at = this.name(place);
    const id = `${run} ${body} ${vertex}`;
    const made = of.map((name, k) => ({
      id: `${id} ${name}`,
      label: `${measure(name).label}, ${at}`,
      unit: answer.units[k] ?? measure(name).unit,
      time: answer.time.data,
      values: row(answer, k),
      fleeting,
    }));
    if (fleeting) this.curves = this.curves.filter((curve) => !curve.fleeting);
    this.add(made.filter(({ values }) => values.some((value) => Number.isFinite(value))));
  }

  /** Plot precomputed curves. */
  add(curves: Curve[]): void {
    for (const curve of curves) {
      const known = this.curves.findIndex(({ id }) => id === curve.id);
      if (known >= 0) this.curves[known] = curve;
      else this.curves.push(curve);
    }
    this.draw();
  }

  /** Add a value to the curves of a sensor of a running machine. */
  push(id: string, time: number, value: number): void {
    const curve = this.curves.find((candidate) => candidate.id === id);
    if (!curve) return;
    const times = curve.time as number[];
    const values = curve.values as number[];
    if (times.length && time < times[times.length - 1]) times.length = values.length = 0;
    times.push(time);
    values.push(reading(value, curve.floor ?? 0));
    if (times.length > STREAM) {
      times.splice(0, STREAM / 4);
      values.splice(0, STREAM / 4);
    }
    this.later();
  }

  unselect(): void {
    this.asked++;
    this.curves = this.curves.filter((curve) => !curve.fleeting);
    this.draw();
  }

  clear(): void {
    this.asked++;
    this.curves = [];
    this.draw();
  }

  private later = paced(100, () => this.draw());

  private stream(name: string): void {
    const sensor = this.app.runs[0].scene.sensors.find((candidate) => candidate.name === name);
    if (!sensor) return;
    const several = sensor.components.length > 1;
    this.add(
      sensor.components.map((component, k) => ({
        id: `live ${name} ${k}`,
        label: several ? `${name} ${component}` : name,
        unit: sensor.units[k] ?? sensor.unit,
        floor: sensor.floors[k],
        time: [],
        values: [],
      })),
    );
  }

  private named(answer: History, run: number, name: string): Curve[] {
    const title = this.app.runs.length > 1 ? `${this.app.runs[run].title}: ` : "";
    const floors = this.app.runs[run].scene.sensors.find((sensor) => sensor.name === name)?.floors ?? [];
    return answer.units.map((unit, k) => ({
      id: `sensor ${run} ${name} ${k}`,
      label: title + (answer.labels?.[k] ?? name),
      unit,
      time: answer.time.data,
      values: row(answer, k).map((value) => reading(value, floors[k] ?? 0)),
      ...(title ? { run, of: `${name} ${k}`, component: k } : {}),
    }));
  }

  private async answered(work: Promise<History>): Promise<History | null> {
    try {
      return await work;
    } catch (error) {
      this.say(error instanceof Error ? error.message : String(error), "error");
      return null;
    }
  }

  private pin(): void {
    for (const curve of this.curves) curve.fleeting = false;
    this.draw();
  }

  private remove(id: string): void {
    const known = this.curves.some((curve) => curve.id === id);
    if (known) this.curves = this.curves.filter((curve) => curve.id !== id);
    else press(this.subtract, (this.subtracts = false));
    this.draw();
  }

  private save(): void {
    const name = fileName(`${this.app.runs[0].title} curves`, "csv");
    download(name, new Blob([csv(this.all())], { type: "text/csv" }));
  }

  /** Differences between curves of other runs and those of the first visible run. */
  private differences(): Curve[] {
    return this.curves.flatMap((curve) => {
      const first = this.curves.find(({ run, of }) => run !== undefined && of === curve.of && run < curve.run!);
      if (!first || curve.of === undefined) return [];
      const made = difference(first, curve);
      if (!made.time.length) return [];
      return [{ ...curve, ...made, id: `difference ${curve.id}`, label: `${curve.label} − ${this.app.runs[first.run!].title}`, subtracted: true }];
    });
  }

  private all(): Curve[] {
    return this.subtracts ? [...this.curves, ...this.differences()] : this.curves;
  }

  /** Update the charts to the present curves. */
  private draw(): void {
    this.element.hidden = !this.curves.length;
    this.keep.hidden = !this.curves.some((curve) => curve.fleeting);
    this.subtract.hidden = !this.differences().length;
    const groups = new Map<string, Curve[]>();
    for (const curve of this.all()) {
      const name = groupOf(curve);
      groups.set(name, [...(groups.get(name) ?? []), curve]);
    }
    for (const [name, chart] of this.charts) {
      if (groups.has(name)) continue;
      chart.close();
      this.charts.delete(name);
    }
    for (const [name, curves] of groups) {
      let chart = this.charts.get(name);
      if (!chart) {
        chart = new Chart(this.app, curves[0].unit, (id) => this.remove(id));
        this.charts.set(name, chart);
        this.body.append(chart.element);
      }
      chart.show(curves);
    }
  }

  private resizable(handle: HTMLElement): void {
    const set = (height: number): void => {
      const most = Math.max(120, window.innerHeight - 240);
      this.body.style.height = `${Math.min(most, Math.max(100, height))}px`;
    };
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      const [from, height] = [event.clientY, this.body.offsetHeight];
      const move = (moved: PointerEvent): void => set(height + from - moved.clientY);
      handle.addEventListener("pointermove", move);
      handle.addEventListener("pointerup", () => handle.removeEventListener("pointermove", move), { once: true });
    });
    handle.addEventListener("keydown", (event) => {
      const way = { ArrowUp: 20, ArrowDown: -20 }[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      set(this.body.offsetHeight + way);
    });
  }
}

/** Curves of one unit share a chart; dimensionless ones only if they are of one kind. */
const groupOf = ({ unit, label, of }: Curve): string =>
  unit === "1" || unit === "" ? `1 ${of?.replace(/ \d+$/, "") ?? label.split(",")[0]}` : unit;

function row(answer: History, k: number): Float64Array {
  const n = answer.time.data.length;
  return answer.values.data.subarray(k * n, (k + 1) * n);
}
