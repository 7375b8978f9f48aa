/** Sensor values of a running machine; a click plots one. */

import { quantity, reading } from "../format/units";
import type { Live } from "../protocol";
import { h, section } from "./dom";
import type { Kit } from "./kit";

const MOST = 12; // number of values of a sensor that are listed; larger fields are shown as curves only

export function mountReadings(kit: Kit): { element: HTMLElement | null; show: (live: Live) => void } {
  const { sensors } = kit.app.runs[0].scene;
  const rows: { at: number; unit: string; floor: number; output: HTMLElement }[] = [];
  const listed: HTMLElement[] = [];
  let at = 0;
  for (const sensor of sensors) {
    const first = at;
    at += sensor.components.length;
    if (sensor.components.length > MOST) continue;
    const several = sensor.components.length > 1;
    sensor.components.forEach((component, k) => {
      const output = h("output");
      rows.push({ at: first + k, unit: sensor.units[k] ?? sensor.unit, floor: sensor.floors[k] ?? 0, output });
      const name = h("button", {
        class: "link",
        text: several ? `${sensor.name} ${component}` : sensor.name,
        title: `Plot ${sensor.name}`,
        attrs: { type: "button" },
        on: { click: () => void kit.plots.sensor(sensor.name) },
      });
      listed.push(h("div", "row reading", name, output));
    });
  }
  const show = ({ sensors: { data } }: Live): void => {
    for (const { at: place, unit, floor, output } of rows) {
      output.textContent = quantity(reading(data[place], floor), unit);
    }
  };
  return { element: rows.length ? section("Sensors", true, h("div", "readings", ...listed)) : null, show };
}
