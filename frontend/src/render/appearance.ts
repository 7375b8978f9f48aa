/** Colours and present appearance of bodies. */

import * as THREE from "three";
import type { Body } from "../protocol";
import type { State } from "../state";
import { key } from "../state";
import type { Appearance } from "./body";

const PALETTE = ["#7f9cbd", "#c2a878", "#8db098", "#bd8d84", "#9c92ba", "#7db0b5", "#b4b27f", "#9fa8b3", "#c08fa6", "#86a97c"];
const GROUND = "#8d9299";
/** CSS colours of runs. */
export const RUNS = ["#5b8cc4", "#d98a4b", "#5fa777", "#b06fa8", "#c0b04a", "#7f8790"];

/** Colours that depend on the theme, read from the style sheet. */
export interface Paint {
  dark: boolean;
  top: THREE.Color;
  bottom: THREE.Color;
  ink: THREE.Color;
  accent: THREE.Color;
  line: THREE.Color;
}

/** Screen colour without conversion: the shaders convert it themselves. */
export function raw(text: string): THREE.Color {
  return new THREE.Color().setStyle(text.trim() || "#888888", THREE.LinearSRGBColorSpace);
}

export function readPaint(element: HTMLElement): Paint {
  const style = getComputedStyle(element);
  const read = (name: string, otherwise: string): THREE.Color => raw(style.getPropertyValue(name) || otherwise);
  const bottom = read("--stage-bottom", "#dfe5ec");
  const dark = bottom.r + bottom.g + bottom.b < 1.2;
  return {
    dark,
    top: read("--stage-top", "#fbfcfd"),
    bottom,
    ink: read("--ink", "#1d232b"),
    accent: read("--accent", "#1c5fa8"),
    line: raw(dark ? "#0d1116" : "#2b333d"),
  };
}

/*CSS colour of a body without a measure; with several runs, the colour of its run. */
export function bodyColour(state: Readonly<State>, run: number, index: number, body: Body): string {
  const chosen = state.looks[key(run, index)]?.colour;
  if (chosen) return chosen;
  if (state.runs.filter(Boolean).length > 1) return RUNS[run % RUNS.length];
  return body.kind === "ground" ? GROUND : PALETTE[index % PALETTE.length];
}

export function appearance(state: Readonly<State>, paint: Paint, run: number, index: number, body: Body): Appearance {
  const name = key(run, index);
  const look = state.looks[name] ?? {};
  const several = state.runs.filter(Boolean).length > 1;
  const over = several && run !== state.runs.indexOf(true) && !state.offset.some((x) => x !== 0);
  const selected = state.selection?.run === run && state.selection.body === index;
  return {
    visible:
      state.runs[run] !== false &&
      (body.kind !== "contact" || state.contacts) &&
      !look.hidden &&
      (state.isolated === null || state.isolated === name),
    colour: raw(bodyColour(state, run, index, body)),
    opacity: look.transparent || body.kind === "contact" ? 0.22 : over ? 0.45 : 1,
    glow: selected && state.measure === null ? paint.accent : null,
    edges: state.edges,
    mesh: state.mesh,
    line: paint.line,
    lineOpacity: paint.dark ? 0.8 : 0.62,
  };
}
