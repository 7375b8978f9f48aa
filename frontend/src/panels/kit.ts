/** Data shared by panels beside the app: messages, plots and selection. */

import type { App } from "../app";
import { number, quantity } from "../format/units";
import { StillTrack } from "../motion/track";
import { position } from "../motion/pose";
import type { Probe, Vec3 } from "../protocol";
import type { Place } from "../state";
import type { Plots } from "./plots";
import type { Say } from "./toasts";

export interface Kit {
  app: App;
  say: Say;
  plots: Plots;
}

export const bodyOf = (app: App, place: Place) => app.runs[place.run].scene.bodies[place.body];

/** Readable name of a place: `lug, node 1203`, or `boom, element 3 at 50.0 %, y 5 mm, z 0 mm`. */
export function placeName(app: App, place: Place): string {
  const body = bodyOf(app, place);
  const node = body.nodes ? body.nodes.data[place.vertex] : null;
  const run = app.runs.length > 1 ? `${app.runs[place.run].title}: ` : "";
  const sections = body.rings ?? body.sections;
  if (sections) {
    const ring = sections.vertex_ring.data[place.vertex], yz = body.rings?.section ?? sections.yz.data;
    const [y, z] = [0, 1].map((i) => quantity(yz[2 * place.vertex + i], "m", 3));
    return `${run}${body.name}, element ${sections.element.data[ring] + 1} at ${number(100 * sections.share.data[ring], 3)} %, y ${y}, z ${z}`;
  }
  return `${run}${body.name}, ${node ? `node ${node}` : `point ${place.vertex + 1}`}`;
}

/** Values at a place; after joints were set, its position is the displayed one. */
export async function probed(app: App, place: Place, time: number): Promise<Probe> {
  const found = await app.source.probe(place.run, place.body, place.vertex, time);
  const { track } = app.runs[place.run];
  if (!(track instanceof StillTrack) || !track.moved) return found;
  return { ...found, position: [...position(bodyOf(app, place), place.vertex, track.row())] as Vec3 };
}

/** Mean frame interval of the first run, s. */
export function spacing(app: App): number {
  const frames = app.runs[0].scene.frames.data;
  return frames.length > 1 ? (frames[frames.length - 1] - frames[0]) / (frames.length - 1) : 0;
}

/** Show a failed request as a message. */
export async function tried<T>(kit: Kit, work: Promise<T>): Promise<T | null> {
  try {
    return await work;
  } catch (error) {
    kit.say(error instanceof Error ? error.message : String(error), "error");
    return null;
  }
}
