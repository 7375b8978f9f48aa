/** Forces, moments, velocities and accelerations of sensors as arrows. */

import * as THREE from "three";
import { before } from "../../motion/track";
import { sidePosition } from "../../motion/pose";
import type { Scene, Sensor } from "../../protocol";
import type { Arrow } from "./symbols";

const LONGEST = 0.45; // length of the largest arrow of a kind, relative to the size of the scene

interface Course {
  sensor: number;
  time: ArrayLike<number>;
  /** Three components at each time. */
  values: ArrayLike<number>[];
}

export class Arrows {
  private courses: Course[] = [];
  private largest = new Map<string, number>();

  constructor(
    private scene: Scene,
    private radius: number,
  ) {}

  /** Sensors drawn as arrows. */
  get wanted(): Sensor[] {
    return this.scene.sensors.filter((sensor) => sensor.arrow && sensor.side && sensor.columns?.length === 3);
  }

  /** Set the history of a sensor: its components at instants. */
  take(name: string, time: ArrayLike<number>, components: ArrayLike<number>[]): void {
    const sensor = this.scene.sensors.findIndex((one) => one.name === name);
    const { arrow, columns } = this.scene.sensors[sensor] ?? {};
    if (!arrow || !columns || columns.some((k) => !components[k])) return;
    const values = columns.map((k) => components[k]);
    this.courses = this.courses.filter((course) => course.sensor !== sensor);
    this.courses.push({ sensor, time, values });
    let most = this.largest.get(arrow) ?? 0;
    for (let i = 0; i < time.length; i++) most = Math.max(most, Math.hypot(values[0][i], values[1][i], values[2][i]));
    this.largest.set(arrow, most);
  }

  /** Arrows at an instant. */
  at(row: ArrayLike<number>, time: number, amplification: number): Arrow[] {
    const out: Arrow[] = [];
    for (const { sensor, time: times, values } of this.courses) {
      const { side, arrow } = this.scene.sensors[sensor];
      const most = this.largest.get(arrow!) ?? 0;
      if (!side || !(most > 0)) continue;
      const i = before(times, time), j = Math.min(i + 1, times.length - 1);
      const span = times[j] - times[i];
      const f = span > 0 ? Math.max(0, Math.min(1, (time - times[i]) / span)) : 0;
      const [x, y, z] = values.map((v) => v[i] + f * (v[j] - v[i]));
      const [px, py, pz] = sidePosition(side, row, amplification);
      out.push({
        at: new THREE.Vector3(px, py, pz),
        value: new THREE.Vector3(x, y, z),
        scale: (LONGEST * this.radius) / most,
        kind: arrow!,
        sensor,
      });
    }
    return out;
  }
}
