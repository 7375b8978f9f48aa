/** One chart of curves with the same unit. */

import uPlot from "uplot";
import type { App } from "../app";
import { mark, number, unitOf } from "../format/units";
import type { Unit } from "../format/units";
import { before } from "../motion/track";
import { button, h } from "./dom";
import type { Curve } from "./plots";

const LIGHT = ["#1c5fa8", "#d9542b", "#2a9d78", "#8a56b0", "#a9780a", "#2f8fc0", "#b0426b", "#6b7280"];
const DARK = ["#6fb0f2", "#ff8f66", "#58cfa6", "#c79aed", "#e5b94e", "#7fd0f5", "#ef86ac", "#a5adb8"];

const DASHES = [[], [8, 4], [3, 3], [10, 3, 3, 3]]; // dash patterns, pixels, of the components of an object

const variable = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const dark = (): boolean => document.documentElement.dataset["theme"] === "dark";

export class Chart {
  readonly element = h("div", "chart");
  private keys = h("div", "keys");
  private room = h("div", "room");
  private plot: uPlot | null = null;
  private curves: Curve[] = [];
  private unit: Unit = { label: "", factor: 1 };
  private made = "";
  private outputs: HTMLElement[] = [];
  private sizes: number[] = [];

  constructor(
    private app: App,
    private base: string,
    private remove: (id: string) => void,
  ) {
    this.element.append(this.keys, this.room);
  }

  show(curves: Curve[]): void {
    this.curves = curves;
    this.unit = unitOf(
      this.base,
      curves.flatMap(({ values }) => extremes(values)),
    );
    this.sizes = curves.map(({ values }) => Math.max(...extremes(values).map(Math.abs)));
    const data = this.data();
    const made = JSON.stringify([curves.map(({ id }) => id), this.unit.label, dark()]);
    if (this.plot && made === this.made) {
      this.plot.setData(data, false);
      this.span(...this.limits());
    } else {
      this.made = made;
      this.plot?.destroy();
      this.plot = new uPlot(this.options(), data, this.room);
      this.legend();
      this.fit();
    }
    this.now(this.app.store.state.time);
  }

  /** Move the time cursor and update the values beside the names. */
  now(time: number): void {
    this.plot?.redraw(false, false);
    this.curves.forEach((curve, k) => {
      if (!curve.time.length) return;
      const i = before(curve.time, time);
      const j = Math.min(i + 1, curve.time.length - 1);
      const span = curve.time[j] - curve.time[i];
      const share = span > 0 ? Math.min(1, Math.max(0, (time - curve.time[i]) / span)) : 0;
      const value = curve.values[i] + share * (curve.values[j] - curve.values[i]);
      // rounding errors of a curve count as zero
      const size = this.sizes[k];
      const shown = Math.abs(value) < 1e-9 * size ? 0 : value * this.unit.factor;
      if (this.outputs[k]) this.outputs[k].textContent = number(shown, 4);
    });
  }

  span(min: number, max: number): void {
    if (max > min) this.plot?.setScale("x", { min, max });
  }

  fit(): void {
    const { clientWidth: width, clientHeight: height } = this.room;
    if (width > 0 && height > 0) this.plot?.setSize({ width, height });
  }

  close(): void {
    this.plot?.destroy();
    this.element.remove();
  }

  private limits(): [number, number] {
    if (!this.app.source.live) return [this.app.player.start, this.app.player.end];
    const ends = this.curves.flatMap(({ time }) => (time.length ? [time[0], time[time.length - 1]] : []));
    return ends.length ? [Math.min(...ends), Math.max(...ends)] : [0, 1];
  }

  private data(): uPlot.AlignedData {
    const scaled = this.curves.map(
      ({ time, values }) =>
        [
          Array.from(time),
          Array.from(values, (value) => (Number.isFinite(value) ? value * this.unit.factor : null)),
        ] as unknown as uPlot.AlignedData,
    );
    const same = this.curves.every(({ time }) => time === this.curves[0].time);
    if (same) return [scaled[0][0], ...scaled.map((one) => one[1])] as uPlot.AlignedData;
    return uPlot.join(scaled);
  }

  /*Colour of a curve; if several runs are compared, the colour of its run. */
  private colour(k: number): string {
    const own = dark() ? DARK : LIGHT;
    const { run } = this.curves[k];
    return run === undefined ? own[k % own.length] : this.app.view.runColours[run % this.app.view.runColours.length];
  }

  private legend(): void {
    this.outputs = this.curves.map(() => h("output"));
    this.keys.replaceChildren(
      ...this.curves.map((curve, k) => {
        const dot = h("i", "dot");
        dot.style.background = this.colour(k);
        return h(
          "span",
          { class: "key", title: curve.label },
          dot,
          h("span", { class: "what", text: curve.label }),
          this.outputs[k],
          h("span", { class: "unit", text: this.unit.label }),
          button(`Remove ${curve.label}`, () => this.remove(curve.id), { icon: "close" }),
        );
      }),
    );
  }

  private options(): uPlot.Options {
    const [muted, line] = [variable("--muted"), variable("--line")];
    const font = `11px ${getComputedStyle(document.body).fontFamily}`;
    const axis: uPlot.Axis = {
      stroke: muted,
      font,
      grid: { stroke: line, width: 1 },
      ticks: { show: false },
      gap: 4,
    };
    const clicked = (plot: uPlot): void => {
      if (plot.cursor.left === undefined || plot.cursor.left < 0 || this.app.source.live) return;
      void this.app.player.seek(plot.posToVal(plot.cursor.left, "x"));
    };
    return {
      width: 300,
      height: 150,
      pxAlign: false,
      legend: { show: false },
      padding: [6, 36, 0, 0],
      cursor: {
        sync: { key: "jousto" },
        y: false,
        points: { size: 6 },
        drag: { x: true, y: false },
        bind: {
          // a click that was no drag shows that instant
          click: (plot) => (event: MouseEvent) => {
            if (plot.select.width < 2) clicked(plot);
            void event;
            return null;
          },
        },
      },
      scales: { x: { time: false, range: (_, min, max) => (min === null ? [0, 1] : [min, max]) } },
      axes: [
        { ...axis, size: 26, values: (_, values) => values.map((v) => `${mark(v)} s`) },
        { ...axis, size: 58, values: (_, values) => values.map((v) => mark(v)) },
      ],
      series: [
        {},
        ...this.curves.map((curve, k) => ({
          label: curve.label,
          stroke: this.colour(k),
          width: curve.subtracted ? 1 : 1.5,
          ...dashes(curve),
          spanGaps: true,
          points: { show: false },
        })),
      ],
      hooks: { draw: [(plot) => this.line(plot)] },
    };
  }

  /** Draw the common time cursor. */
  private line(plot: uPlot): void {
    const { time } = this.app.store.state;
    const x = Math.round(plot.valToPos(time, "x", true)) + 0.5;
    const { left, top, width, height } = plot.bbox;
    if (!(x >= left && x <= left + width)) return;
    const { ctx } = plot;
    ctx.save();
    ctx.strokeStyle = variable("--ink");
    ctx.globalAlpha = 0.75;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([]); // dashes of the last curve
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(x, top + height);
    ctx.stroke();
    ctx.restore();
  }
}

/** Components of one run, and differences, share a colour: dashes distinguish them. */
function dashes({ run, component, subtracted }: Curve): { dash?: number[] } {
  if (run === undefined) return {};
  const dash = DASHES[(component ?? 0) % DASHES.length];
  return subtracted ? { dash: [1, 3, ...dash] } : dash.length ? { dash } : {};
}

function extremes(values: ArrayLike<number>): number[] {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < values.length; i++) {
    if (values[i] < low) low = values[i];
    if (values[i] > high) high = values[i];
  }
  return [low, high];
}
