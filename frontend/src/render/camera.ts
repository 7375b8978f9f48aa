/** Camera: target, distance and two angles about the upward direction. */

import * as THREE from "three";

const FIELD = (28 * Math.PI) / 180; // vertical field of view

export type Direction = "x" | "-x" | "y" | "-y" | "z" | "-z" | "iso";

export class Rig {
  readonly perspective = new THREE.PerspectiveCamera((FIELD * 180) / Math.PI, 1, 0.1, 100);
  readonly parallel = new THREE.OrthographicCamera();
  target = new THREE.Vector3();
  distance = 1;
  azimuth = 0.7;
  elevation = 0.42;
  usesPerspective = true;
  width = 1;
  height = 1;
  private up: THREE.Vector3;
  private first: THREE.Vector3;
  private second: THREE.Vector3;
  private turning: { from: number[]; to: number[]; began: number } | null = null;

  constructor(up: readonly [number, number, number]) {
    this.up = new THREE.Vector3(...up).normalize();
    // azimuth from the x axis if it is perpendicular to the upward direction
    const aside = Math.abs(this.up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 0, 1);
    this.first = aside.addScaledVector(this.up, -aside.dot(this.up)).normalize();
    this.second = new THREE.Vector3().crossVectors(this.up, this.first);
    this.azimuth = -Math.PI / 2 + 0.65;
  }

  get camera(): THREE.PerspectiveCamera | THREE.OrthographicCamera {
    return this.usesPerspective ? this.perspective : this.parallel;
  }

  /** Vector from target to camera. */
  get backward(): THREE.Vector3 {
    const { azimuth: a, elevation: e } = this;
    return new THREE.Vector3()
      .addScaledVector(this.first, Math.cos(e) * Math.cos(a))
      .addScaledVector(this.second, Math.cos(e) * Math.sin(a))
      .addScaledVector(this.up, Math.sin(e));
  }

  get rightward(): THREE.Vector3 {
    const { azimuth: a } = this;
    return new THREE.Vector3().addScaledVector(this.first, -Math.sin(a)).addScaledVector(this.second, Math.cos(a));
  }

  get upward(): THREE.Vector3 {
    return this.backward.cross(this.rightward);
  }

  get above(): THREE.Vector3 {
    return this.up;
  }

  /** Size of a CSS pixel at the target, m. */
  get pixel(): number {
    return (2 * this.distance * Math.tan(FIELD / 2)) / this.height;
  }

  /** Set both cameras with a sphere between near and far plane. */
  update(middle: THREE.Vector3, radius: number): void {
    const back = this.backward, aspect = this.width / this.height;
    const eye = this.target.clone().addScaledVector(back, this.distance);
    const right = this.rightward, up = this.upward;
    const away = eye.clone().sub(middle).dot(back);
    for (const camera of [this.perspective, this.parallel]) {
      camera.matrixAutoUpdate = false;
      camera.matrix.makeBasis(right, up, back).setPosition(eye);
      camera.matrixWorld.copy(camera.matrix);
      camera.matrixWorldInverse.copy(camera.matrix).invert();
    }
    const far = Math.max(away + radius, 1e-9);
    this.perspective.far = Math.max(far, this.distance * 1.01);
    this.perspective.near = Math.max(away - radius, 2e-3 * this.distance, 1e-5 * this.perspective.far);
    this.perspective.aspect = aspect;
    this.perspective.updateProjectionMatrix();
    const half = this.distance * Math.tan(FIELD / 2);
    Object.assign(this.parallel, { left: -half * aspect, right: half * aspect, top: half, bottom: -half });
    this.parallel.near = Math.min(away - radius, 0);
    this.parallel.far = far;
    this.parallel.updateProjectionMatrix();
  }

  /** Fit points into the picture in the present direction. */
  fit(corners: THREE.Vector3[]): void {
    const right = this.rightward, up = this.upward, back = this.backward;
    const room = 0.88; // of the picture
    const tanUp = Math.tan(FIELD / 2) * room, tanRight = (tanUp * this.width) / this.height;
    const ends = (v: THREE.Vector3): [number, number] => {
      const at = corners.map((corner) => corner.dot(v));
      return [Math.min(...at), Math.max(...at)];
    };
    const [left, far] = ends(right), [low, high] = ends(up), [behind, front] = ends(back);
    this.target.set(0, 0, 0);
    for (const [v, at] of [[right, (left + far) / 2], [up, (low + high) / 2], [back, (behind + front) / 2]] as const) {
      this.target.addScaledVector(v, at);
    }
    // each corner requires a distance at which it is still in view; near parts look larger,
    // so that the centre of the picture differs from that of the box
    for (let pass = 0; pass < 8; pass++) {
      const at = corners.map((corner) => {
        const x = corner.clone().sub(this.target);
        return { near: this.usesPerspective ? x.dot(back) : 0, x: x.dot(right), y: x.dot(up) };
      });
      this.distance = Math.max(
        1e-9,
        ...at.map(({ near, x, y }) => near + Math.max(0.05 * Math.abs(near), Math.abs(x) / tanRight, Math.abs(y) / tanUp)),
      );
      for (const [axis, of] of [[right, "x"], [up, "y"]] as const) {
        const seen = at.map((point) => point[of] / (this.distance - point.near));
        this.target.addScaledVector(axis, (this.distance * (Math.min(...seen) + Math.max(...seen))) / 2);
      }
    }
  }

  orbit(right: number, down: number): void {
    this.turning = null;
    this.azimuth -= right;
    this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + down));
  }

  /** Shift the picture by CSS pixels. */
  pan(right: number, down: number): void {
    this.target.addScaledVector(this.rightward, -right * this.pixel).addScaledVector(this.upward, down * this.pixel);
  }

  /** Zoom by a factor about a point of the picture (pixels from its centre). */
  zoom(factor: number, right: number, down: number): void {
    const move = (1 - factor) * this.pixel;
    this.target.addScaledVector(this.rightward, right * move).addScaledVector(this.upward, -down * move);
    this.distance *= factor;
  }

  look(direction: Direction): void {
    const quarter = Math.PI / 2;
    const angles: Record<Direction, [number, number]> = {
      x: [0, 0],
      "-x": [Math.PI, 0],
      y: [quarter, 0],
      "-y": [-quarter, 0],
      z: [-quarter, quarter],
      "-z": [-quarter, -quarter],
      iso: [-quarter + 0.65, 0.42],
    };
    const [azimuth, elevation] = angles[direction];
    const turns = Math.round((this.azimuth - azimuth) / (2 * Math.PI));
    this.turning = { from: [this.azimuth, this.elevation], to: [azimuth + 2 * Math.PI * turns, elevation], began: NaN };
  }

  /** Turn towards the requested direction; returns whether it is still turning. */
  tick(now: number, still: boolean): boolean {
    if (!this.turning) return false;
    if (Number.isNaN(this.turning.began)) this.turning.began = now;
    const share = still ? 1 : Math.min(1, (now - this.turning.began) / 0.28);
    const f = share * share * (3 - 2 * share);
    const { from, to } = this.turning;
    this.azimuth = from[0] + f * (to[0] - from[0]);
    this.elevation = from[1] + f * (to[1] - from[1]);
    if (share >= 1) this.turning = null;
    return true;
  }
}
