/** Time line: play, step, speed, loop, drag, marks of events, and windows of long runs. */

import { clock } from "../format/units";
import { ticks, zoomed } from "../format/range";
import { FramesTrack, ModeTrack } from "../motion/track";
import { button, h, press } from "./dom";
import { icon } from "./icons";
import type { Kit } from "./kit";
import { spacing, tried } from "./kit";

const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];

export function mountTimeline(kit: Kit): void {
  const { app } = kit;
  const { scene } = app.runs[0];
  const tracks = (): FramesTrack[] =>
    app.runs.map(({ track }) => track).filter((track) => track instanceof FramesTrack);
  if (!(app.player.end > app.player.start)) {
    const text =
      scene.what === "part"
        ? "A part has no time: it is shown undeformed."
        : "Nothing moves here: the machine is shown as it is declared.";
    app.slots.bottom.append(h("div", { class: "timeline still", text }));
    return;
  }
  const modes = app.runs[0].track instanceof ModeTrack;

  const play = button("Play", () => app.player.toggle(), { icon: "play", key: "space", class: "play" });
  const back = button("One frame back", () => app.player.step(-1), { icon: "back", key: "←" });
  const next = button("One frame on", () => app.player.step(1), { icon: "next", key: "→" });
  const loop = button("Repeat", () => app.store.set({ loop: !app.store.state.loop }), { icon: "loop" });
  const now = h("output", { class: "now", attrs: { "aria-label": "Time" } });
  const { element: rail, draw } = railOf(kit, modes);
  const speed = speedSelect(kit, modes);

  const element = h("div", { class: "timeline", attrs: { "aria-label": "Time line" } });
  element.append(h("div", "group", back, play, next), rail, h("div", "group", now, speed, loop));
  if (tracks().length) {
    const zoom = button("Zoom into time", () => rezoom(0.25), { icon: "zoom", key: "ctrl + wheel" });
    const whole = button("Whole run", () => rezoom(Infinity), { icon: "whole" });
    const rezoom = (factor: number): void => void tried(kit, windowed(kit, tracks(), factor));
    rail.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        if (event.ctrlKey) rezoom(event.deltaY > 0 ? 2 : 0.5);
        else app.player.step(event.deltaY > 0 ? 1 : -1);
      },
      { passive: false },
    );
    element.lastElementChild!.append(zoom, whole);
    const update = (): void => {
      const [start, end] = scene.window;
      const all = app.player.end - app.player.start >= 0.999 * (end - start);
      whole.hidden = all;
      draw();
    };
    for (const track of tracks()) track.onChange(update);
    update();
  }
  app.slots.bottom.append(element);

  app.store.watch(["playing"], ({ playing }) => {
    play.replaceChildren(icon(playing ? "pause" : "play"));
    play.setAttribute("aria-label", playing ? "Pause" : "Play");
  });
  app.store.watch(["loop"], (state) => press(loop, state.loop));
  app.store.watch(["time", "mode"], ({ time }) => {
    if (modes) {
      const share = (time - app.player.start) / (app.player.end - app.player.start);
      now.textContent = `${Math.round(360 * share)}° of a period`;
    } else now.textContent = `${clock(time, Math.min(0.001, spacing(app)))} s`;
    draw();
  });
}

/** Request another time window of the run; an infinite `factor` gives the whole run. */
async function windowed(kit: Kit, tracks: FramesTrack[], factor: number): Promise<void> {
  const { player, store, runs } = kit.app;
  const whole = runs[0].scene.window;
  const now: [number, number] = [player.start, player.end];
  const [start, end] = Number.isFinite(factor) ? zoomed(now, whole, store.state.time, factor) : whole;
  if (start === now[0] && end === now[1]) return;
  await Promise.all(tracks.map((track) => track.window(start, end)));
  await player.seek(store.state.time);
}

function speedSelect(kit: Kit, modes: boolean): HTMLElement {
  const { store, player } = kit.app;
  const select = h("select", { class: "speed", title: "Speed", attrs: { "aria-label": "Speed" } });
  // modes have periods of microseconds to seconds: the speed refers to real time
  if (modes) {
    const periods = [0.1, 0.25, 0.5, 1, 2, 4];
    for (const each of periods) {
      select.append(h("option", { text: `${each} ${each > 1 ? "periods" : "period"}/s`, attrs: { value: `${each}` } }));
    }
    select.value = "0.5";
    const apply = (): void => store.set({ speed: Number(select.value) * (player.end - player.start) });
    select.addEventListener("change", apply);
    store.watch(["mode"], apply);
    return select;
  }
  const length = player.end - player.start;
  const list = SPEEDS.filter((speed) => length / speed <= 3600 && length / speed >= 0.05);
  if (!list.includes(1)) list.push(1);
  for (const speed of list.sort((a, b) => a - b)) {
    const text = speed < 1 ? `1/${Math.round(1 / speed)} ×` : `${speed} ×`;
    select.append(h("option", { text, attrs: { value: `${speed}` } }));
  }
  select.addEventListener("change", () => store.set({ speed: Number(select.value) }));
  // initial speed: three seconds to half a minute for the whole run
  const start = list.reduce((best, speed) =>
    Math.abs(Math.log(length / speed / 8)) < Math.abs(Math.log(length / best / 8)) ? speed : best,
  );
  store.set({ speed: length >= 2 && length <= 60 ? 1 : start });
  store.watch(["speed"], ({ speed }) => {
    const known = list.find((candidate) => Math.abs(candidate / speed - 1) < 1e-6);
    select.value = known === undefined ? "" : `${known}`;
  });
  return select;
}

/** The rail with its knob: a slider for the keyboard, a line to drag for the mouse. */
function railOf(kit: Kit, modes: boolean): { element: HTMLElement; draw: () => void } {
  const { app } = kit;
  const { store, player } = app;
  const fill = h("div", "fill");
  const knob = h("div", "knob");
  const marks = h("div", "marks");
  const bubble = h("div", "bubble");
  const element = h(
    "div",
    {
      class: "rail",
      attrs: { role: "slider", tabindex: "0", "aria-label": "Time", "aria-orientation": "horizontal" },
    },
    h("div", "groove", fill),
    marks,
    knob,
    bubble,
  );
  const at = (event: PointerEvent): number => {
    const box = element.getBoundingClientRect();
    const share = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    return player.start + share * (player.end - player.start);
  };
  let playing = false;
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    playing = store.state.playing;
    player.pause();
    void tried(kit, player.seek(at(event)));
  });
  element.addEventListener("pointermove", (event) => {
    const time = at(event);
    bubble.textContent = modes ? "" : `${clock(time, Math.min(0.001, spacing(app)))} s`;
    bubble.style.left = `${(100 * (time - player.start)) / (player.end - player.start)}%`;
    if (element.hasPointerCapture(event.pointerId)) void tried(kit, player.seek(time));
  });
  element.addEventListener("pointerup", () => playing && player.play());
  element.addEventListener("keydown", (event) => {
    const ends: Record<string, number> = { Home: player.start, End: player.end };
    const steps: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10 };
    if (event.key in ends) void tried(kit, player.seek(ends[event.key]));
    else if (event.key in steps) player.step(steps[event.key]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });

  let drawn = "";
  const draw = (): void => {
    const { start, end } = player;
    const { time } = store.state;
    const share = (100 * Math.min(1, Math.max(0, (time - start) / (end - start)))).toFixed(3);
    fill.style.width = `${share}%`;
    knob.style.left = `${share}%`;
    element.setAttribute("aria-valuemin", String(start));
    element.setAttribute("aria-valuemax", String(end));
    element.setAttribute("aria-valuenow", String(time));
    element.setAttribute("aria-valuetext", modes ? `${share} %` : `${clock(time, 0.001)} seconds`);
    const state = `${start} ${end}`;
    if (state === drawn) return;
    drawn = state;
    marks.replaceChildren();
    if (modes) return;
    for (const value of ticks(start, end, 8)) {
      const mark = h("span", { class: "tick", text: tickText(value, end - start) });
      const share = (value - start) / (end - start);
      mark.style.left = `${100 * share}%`;
      // labels at the ends stay within the rail
      mark.style.transform = `translateX(${share < 0.02 ? 0 : share > 0.98 ? -100 : -50}%)`;
      marks.append(mark);
    }
    for (const event of app.runs[0].scene.events ?? []) {
      if (event.time < start || event.time > end) continue;
      const title = `${event.name}, at ${clock(event.time, 0.001)} s`;
      const mark = h("button", {
        class: "event",
        title,
        attrs: { type: "button", "aria-label": `Go to ${title}`, tabindex: "-1" },
        on: { click: () => void tried(kit, player.seek(event.time)) },
      });
      mark.addEventListener("pointerdown", (pressed) => pressed.stopPropagation());
      mark.style.left = `${(100 * (event.time - start)) / (end - start)}%`;
      marks.append(mark);
    }
  };
  return { element, draw };
}

function tickText(value: number, length: number): string {
  return clock(value, 10 ** Math.floor(Math.log10(length / 8))).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
}
