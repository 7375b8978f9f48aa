/** Comparison of runs: difference of two curves, and whether two scenes show the same machine. */

import { before } from "../motion/track";
import type { Scene } from "../protocol";

interface Course {
  time: ArrayLike<number>;
  values: ArrayLike<number>;
}

/*`b - a` at the instants of both curves, in their common time range; linear between instants. */
export function difference(a: Course, b: Course): { time: Float64Array; values: Float64Array } {
  if (!a.time.length || !b.time.length) return { time: new Float64Array(), values: new Float64Array() };
  const first = Math.max(a.time[0], b.time[0]);
  const last = Math.min(a.time[a.time.length - 1], b.time[b.time.length - 1]);
  const all = new Set([...Array.from(a.time), ...Array.from(b.time)].filter((t) => t >= first && t <= last));
  const time = Float64Array.from(all).sort();
  return { time, values: time.map((t) => at(b, t) - at(a, t)) };
}

function at({ time, values }: Course, t: number): number {
  const i = before(time, t);
  const j = Math.min(i + 1, time.length - 1);
  const span = time[j] - time[i];
  // exact value at an instant of the curve, so that an unknown neighbour has no influence
  return t <= time[i] || !(span > 0) ? values[i] : values[i] + ((t - time[i]) / span) * (values[j] - values[i]);
}

/** Sentence on the difference between two machines; empty if they are equal. */
export function unlike(first: Scene, other: Scene, names: readonly [string, string]): string {
  const groups: [string, string, (scene: Scene) => string[]][] = [
    ["body", "bodies", (scene) => scene.bodies.map(({ name }) => name)],
    ["joint", "joints", (scene) => scene.symbols.filter(({ group }) => group === "joint").map(({ name }) => name)],
  ];
  const found = groups.flatMap(([one, several, of]) => {
    const [here, there] = [new Set(of(first)), new Set(of(other))];
    const missing = [...here].filter((name) => !there.has(name)), added = [...there].filter((name) => !here.has(name));
    return ([["without", missing], ["with", added]] as const).flatMap(([how, list]) =>
      list.length ? `${how} ${list.length > 1 ? several : one} ${some(list)}` : [],
    );
  });
  return found.length ? `${names[1]} is another machine than ${names[0]}: ${found.join(", ")}.` : "";
}

const some = (names: string[]): string =>
  names.slice(0, 3).map((name) => `'${name}'`).join(", ") + (names.length > 3 ? ` and ${names.length - 3} more` : "");
