/** Panel of a running machine: play, inputs, parameters, pulling, recording, lateness. */

import { clock, number, quantity } from "../format/units";
import type { Input, Live } from "../protocol";
import { button, h, hint, press, section, slider, toggle } from "./dom";
import type { Slider } from "./dom";
import { icon } from "./icons";
import type { Kit } from "./kit";
import { tried } from "./kit";
import { Lateness } from "./lateness";
import { mountPad } from "./pad";
import { mountPull } from "./pull";
import { mountReadings } from "./readings";

/** Keys of the first inputs: one lowers, the other raises. */
const KEYS = [["a", "q"], ["s", "w"], ["z", "x"], ["r", "v"]] as const;

const FEW = 8; // number of parameters that are shown at the same time

export function mountLive(kit: Kit): void {
  const { app } = kit;
  const { source, store, slots, view } = app;
  if (!source.live) return;
  const order = (what: Record<string, unknown>): void => void tried(kit, source.order(what));

  // footer: clock of the machine
  let playing = false;
  const play = button("Run", () => order({ do: playing ? "pause" : "play" }), { icon: "play", class: "play", key: "space" });
  const step = button("One step", () => order({ do: "step" }), { icon: "next", key: "→" });
  const reset = button("Back to the start", () => order({ do: "reset" }), { icon: "reset" });
  let recording = false;
  let file = "";
  let since = 0;
  const record = button("Record to a file", () => order({ do: "record", on: !recording }), { icon: "record", text: true, class: "record" });
  const now = h("output", { class: "now", attrs: { "aria-label": "Time of the machine" } });
  const factor = h("output", { class: "now", title: "Seconds of the machine a second of the watch" });
  const note = h("span", "hint");
  const speed = h("select", { class: "speed", title: "Speed", attrs: { "aria-label": "Speed" } });
  for (const [value, text] of [["1", "real time"], ["0.5", "1/2 ×"], ["0.2", "1/5 ×"], ["0.1", "1/10 ×"], ["2", "2 ×"], ["0", "as fast as it can"]]) {
    speed.append(h("option", { text, attrs: { value } }));
  }
  speed.addEventListener("change", () => order({ do: "speed", value: Number(speed.value) }));
  const foot = h("div", "timeline live", h("div", "group", play, step, reset, source.served ? record : ""), note, h("span", "grow"), h("div", "group", now, speed, factor));
  slots.bottom.replaceChildren(...[...slots.bottom.children].filter((child) => !child.classList.contains("still")), foot);

  const inputs = mountInputs(kit, order);
  const state = h("dl", "figures");
  const damage = h("div", "damages");
  const lateness = new Lateness();
  const pulling = toggle("Pull with the mouse", (on) => store.set({ tool: on ? "pull" : "select" }));
  store.watch(["tool"], ({ tool }) => pulling.set(tool === "pull"));
  const readings = mountReadings(kit);
  const panels = [
    inputs,
    mountParameters(kit),
    source.served ? section("Pull", true, pulling.element, hint("Drag a body: a spring and a damper pull it towards the cursor.")) : null,
    readings.element,
    section("Time keeping", true, state, ...(source.served ? [h("p", { class: "hint", text: "How late steps were:" }), lateness.element] : [])),
  ];
  const damages = section("Damage", true, damage);
  damages.hidden = true;
  slots.right.prepend(...panels.filter((panel) => panel !== null), damages);
  if (source.served) mountPull(kit, order);

  window.addEventListener("keydown", (event) => {
    const { target } = event;
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (target instanceof HTMLElement && target.closest("input:not([type=range]), select, button, summary, dialog")) return;
    if (event.key === " ") play.click();
    else if (event.key === "ArrowRight") step.click();
    else return;
    event.preventDefault();
  });

  let last = 0;
  let told = 0;
  let said = "";
  source.onLive((live: Live) => {
    if (playing !== live.playing) {
      playing = live.playing;
      play.replaceChildren(icon(playing ? "pause" : "play"));
      play.setAttribute("aria-label", playing ? "Pause" : "Run");
      step.disabled = playing;
    }
    if ((live.recording ?? "") !== file) {
      if (file) kit.say(`${clock(Math.max(0, last - since), 0.01)} s are recorded in ${file}.`);
      if (live.recording) kit.say(`Recording to ${live.recording}.`);
      since = live.time;
      file = live.recording ?? "";
      recording = !!file;
      press(record, recording);
      label(record, recording ? "End the record" : "Record to a file");
    }
    last = live.time;
    note.textContent = file ? `${clock(Math.max(0, live.time - since), 0.1)} s in ${file}` : "";
    if (live.message && live.message !== said) kit.say(live.message, "error");
    said = live.message;
    plot(kit, live);
    // update text ten times a second, the limit of readability
    if (performance.now() - told < 100) return;
    told = performance.now();
    readings.show(live);
    now.textContent = `${clock(live.time, 0.01)} s`;
    factor.textContent = playing ? `× ${number(live.factor, 3)}` : "paused";
    factor.classList.toggle("wrong", playing && speed.value === "1" && live.factor < 0.95);
    state.replaceChildren(
      ...[
        ["Real-time factor", number(live.factor, 3)],
        ["Longest step", quantity(live.worst, "s", 3)],
      ].flatMap(([term, text]) => [h("dt", { text: term }), h("dd", { text })]),
    );
    lateness.show(live.late);
    damages.hidden = !live.damage.length;
    damage.replaceChildren(...live.damage.map(({ name, value }) => bar(name, value)));
  });
  view.redraw();
}

/** Change the text of a button. */
function label(element: HTMLElement, text: string): void {
  element.title = text;
  element.setAttribute("aria-label", text);
  element.querySelector("span")!.textContent = text;
}

/** Extend the sensor curves while the machine runs. */
function plot(kit: Kit, live: Live): void {
  if (!kit.plots.shown) return;
  let at = 0;
  for (const sensor of kit.app.runs[0].scene.sensors) {
    sensor.components.forEach((_, k) => kit.plots.push(`live ${sensor.name} ${k}`, live.time, live.sensors.data[at++]));
  }
}

function bar(name: string, value: number): HTMLElement {
  const fill = h("div", "fill");
  fill.style.width = `${Math.min(100, 100 * value)}%`;
  return h(
    "div",
    { class: `damage${value >= 1 ? " wrong" : ""}` },
    h("div", "row", h("span", { text: name }), h("output", { text: number(value, 3) })),
    h("div", "groove", fill),
  );
}

function mountInputs(kit: Kit, order: (what: Record<string, unknown>) => void): HTMLElement {
  const inputs = kit.app.runs[0].scene.inputs ?? [];
  if (!inputs.length) {
    return section("Inputs", true, hint("The model has no Input: declare a signal of this kind to steer a force or a drive from here."));
  }
  const values = inputs.map((input) => input.value);
  const sliders: Slider[] = [];
  const set = (k: number, wanted: number): void => {
    const { low, high, name } = inputs[k];
    const value = Math.min(high, Math.max(low, wanted));
    if (value === values[k]) return;
    values[k] = value;
    sliders[k].set(value);
    order({ do: "set", name, value });
  };
  inputs.forEach((input, k) => {
    const unit = input.unit === "1" ? "" : ` ${input.unit}`;
    const made = slider(input.name, { low: input.low, high: input.high }, (v) => `${number(v, 3)}${unit}`, (v) => {
      values[k] = v;
      order({ do: "set", name: input.name, value: v });
    });
    made.set(input.value);
    // double click: initial value
    made.input.addEventListener("dblclick", () => set(k, input.value));
    if (KEYS[k]) {
      made.element.firstElementChild!.firstElementChild!.append(
        " ",
        h("kbd", { text: KEYS[k][0].toUpperCase() }),
        h("kbd", { text: KEYS[k][1].toUpperCase() }),
      );
    }
    sliders.push(made);
  });
  steer(inputs, values, set);
  mountPad(inputs, set, (name) => kit.say(`Gamepad: ${name}. Its sticks move the first inputs.`));
  return section("Inputs", true, ...sliders.map(({ element }) => element));
}

/*Held keys move inputs at a constant rate: the whole range in two seconds. */
function steer(inputs: readonly Input[], values: readonly number[], set: (k: number, value: number) => void): void {
  const held = new Map<string, { k: number; way: number }>();
  let last = 0;
  const move = (now: number): void => {
    const passed = Math.min(0.1, (now - last) / 1000);
    last = now;
    for (const { k, way } of held.values()) {
      set(k, values[k] + (way * passed * (inputs[k].high - inputs[k].low)) / 2);
    }
    if (held.size) requestAnimationFrame(move);
  };
  window.addEventListener(
    "keydown",
    (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.target instanceof HTMLInputElement && !["range", "checkbox"].includes(event.target.type)) return;
      const key = event.key.toLowerCase();
      const k = KEYS.findIndex((pair) => pair.some((one) => one === key));
      if (k < 0 || k >= inputs.length) return;
      event.preventDefault();
      if (held.has(key)) return;
      held.set(key, { k, way: KEYS[k][0] === key ? -1 : 1 });
      if (held.size === 1) {
        last = performance.now();
        requestAnimationFrame(move);
      }
    },
    { capture: true },
  );
  window.addEventListener("keyup", (event) => held.delete(event.key.toLowerCase()));
  window.addEventListener("blur", () => held.clear());
}

function mountParameters(kit: Kit): HTMLElement | null {
  const parameters = kit.app.runs[0].scene.parameters ?? [];
  if (!parameters.length) return null;
  const rows = parameters.map(({ name, value, unit, low, high }) => {
    const input = h("input", {
      attrs: { type: "number", step: "any", value: String(value), "aria-label": name, ...(low === null ? {} : { min: `${low}` }), ...(high === null ? {} : { max: `${high}` }) },
    });
    let holds = value;
    const back = (): void => void (input.value = String(holds));
    const change = async (): Promise<void> => {
      if (!input.checkValidity() || !input.value) {
        kit.say(`${name} must be a number${low === null ? "" : ` from ${low}`}${high === null ? "" : ` to ${high}`}; it stays ${holds}.`, "error");
        back();
        return;
      }
      const wanted = Number(input.value);
      try {
        await kit.app.source.order({ do: "parameter", name, value: wanted });
        holds = wanted;
      } catch (error) {
        kit.say(`${(error as Error).message}. ${name} stays ${holds}${unit === "1" ? "" : ` ${unit}`}.`, "error");
        back();
      }
    };
    input.addEventListener("change", () => void change());
    // another page may have changed it
    kit.app.renewed.add((scene) => {
      holds = scene.parameters?.find((parameter) => parameter.name === name)?.value ?? holds;
      if (document.activeElement !== input) back();
    });
    return h("label", "row parameter", h("span", { text: name }), input, h("span", { class: "unit", text: unit === "1" ? "" : unit }));
  });
  return section("Parameters", rows.length <= FEW, hint("A change takes effect at once; the machine keeps its state."), ...rows);
}
