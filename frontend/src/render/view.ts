/** The picture: rendering on change, and queries of positions in it. */

import * as THREE from "three";
import type { Run } from "../app";
import type { Player } from "../motion/player";
import { position } from "../motion/pose";
import { StillTrack } from "../motion/track";
import type { Vec3 } from "../protocol";
import type { Source } from "../source/source";
import type { Place, State, Store } from "../state";
import type { Paint } from "./appearance";
import { RUNS, bodyColour, readPaint } from "./appearance";
import { Background } from "./background";
import { measureNumber } from "./measures";
import type { Direction } from "./camera";
import { Rig } from "./camera";
import { control } from "./controls";
import { Grid } from "./grid";
import { Machine } from "./machine";
import { MAPS, colourAt, ramp } from "./maps";
import type { Click, Drag } from "./mouse";
import { Mouse } from "./mouse";
import { Picker } from "./picker";
import { NOWHERE, Shared } from "./shared";
import { Captions } from "./captions";
import { Compass } from "./compass";
import { Shadow } from "./shadow";
import { Ranges } from "./ranges";
import { Traces } from "./traces";

/** Object under a point of the picture. */
export interface Hit extends Place {
  position: Vec3;
  /** Index of the symbol in the scene; body and vertex are -1 then. */
  symbol?: number;
  /** Index of the displayed contact force; body and vertex are -1 then. */
  touch?: number;
}

const OUTLINE = 5000; // largest number of vertices that define the outline of the picture

export class View {
  readonly canvas: HTMLCanvasElement;
  readonly maps = MAPS;
  readonly ramp = ramp;
  readonly runColours = RUNS;
  readonly counters = { frames: 0, drawMs: 0, heap: 0 };
  readonly rig: Rig;
  readonly machines: Machine[];
  readonly grid: Grid;
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private shared = new Shared();
  private background = new Background();
  private picker: Picker;
  private ranges: Ranges;
  private traces: Traces;
  private shadow: Shadow;
  private compass: Compass;
  private captions: Captions;
  private middle: THREE.Vector3;
  private radius: number;
  private floor: number;
  private corners: THREE.Vector3[];
  private paint: Paint;
  private pending = 0;
  private drawing = false;
  private looksChanged = true;
  /** Whether everything is in view and the camera was not moved since. */
  private fitted = false;
  private drawn = new Set<() => void>();
  private mouse: Mouse;
  private followed: Vec3 | null = null;

  constructor(
    private stage: HTMLElement,
    private store: Store,
    runs: Run[],
    private player: Player,
    private source: Source,
  ) {
    const { scene } = runs[0];
    this.rig = new Rig(scene.up);
    const [low, high] = bounds(runs);
    this.middle = low.clone().add(high).multiplyScalar(0.5);
    this.radius = Math.max(0.5 * low.distanceTo(high), 1e-6);
    // an element without size still needs a picture
    const room = new THREE.Vector3(1, 1, 1).multiplyScalar(0.04 * this.radius);
    this.corners = corners(low.clone().sub(room), high.clone().add(room));
    this.floor = Math.min(...corners(low, high).map((corner) => corner.dot(this.rig.above)));

    this.renderer = openRenderer();
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // the shaders write screen colours
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.sortObjects = true;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", "The machine; drag to turn, wheel to zoom");
    stage.prepend(this.canvas);

    this.paint = readPaint(document.documentElement);
    this.grid = new Grid(this.rig.above, this.middle, this.radius, this.floor);
    this.shadow = new Shadow(this.rig.above, this.middle, this.radius, this.floor);
    this.compass = new Compass(this.shared);
    this.captions = new Captions(stage, this.grid.step);
    this.scene.matrixWorldAutoUpdate = false;
    this.scene.add(this.background.mesh, this.grid.mesh, this.shadow.mesh);
    this.machines = [];
    runs.forEach((run, k) => {
      run.track.onChange(() => this.redraw());
      this.build(run, k);
    });
    this.picker = new Picker(this.renderer);
    this.traces = new Traces(store, this.machines, source, this.middle, () => this.redraw());
    this.scene.add(this.traces.group);
    this.ranges = new Ranges(store, this.machines, source);
    this.repaint();
    new MutationObserver(() => this.repaint()).observe(document.documentElement, { attributeFilter: ["data-theme"] });
    new ResizeObserver(() => this.resize()).observe(stage);
    this.resize();
    this.fit();
    this.store.watch(null, (_, changed) => {
      if (!changed.has("time") || changed.size > 1) this.looksChanged = true;
      this.redraw();
    });
    this.store.watch(["offset"], () => this.counters.frames && this.fit());
    this.mouse = new Mouse(this, store);
    control(this.canvas, this.rig, this.mouse, () => {
      this.fitted = false;
      this.redraw();
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      for (const machine of this.machines) machine.forget();
      this.redraw();
    });
  }

  /** Create the picture of a run, replacing that of its old scene. */
  build(run: Run, k: number): void {
    const before = this.machines[k], last = this.machines[k - 1];
    const firstThing = before?.firstThing ?? (last ? last.firstThing + last.things : 0);
    const machine = new Machine(run, this.shared, this.middle, this.radius, firstThing, this.source, () => this.redraw(), (message) =>
      this.store.set({ message }),
    );
    if (before) {
      this.scene.remove(before.group);
      before.dispose();
    }
    this.machines[k] = machine;
    this.scene.add(machine.group);
    void machine.load().then(() => this.redraw());
    this.looksChanged = true;
    this.redraw();
  }

  /** Draw at the next animation frame; several calls draw once. */
  redraw(): void {
    if (this.pending || this.drawing) return;
    this.pending = requestAnimationFrame((now) => this.frame(now));
  }

  /** Draw at once, so that the canvas can be copied in the same task. */
  drawNow(): void {
    const { state } = this.store;
    const began = performance.now();
    this.drawing = true;
    this.applyLooks(state);
    for (const machine of this.machines) if (state.runs[machine.run.index] !== false) machine.update(state);
    for (const machine of this.machines) machine.move(this.renderer);
    this.ranges.update(this.renderer);
    this.traces.update(state);
    const range = this.store.state.range ?? [0, 1];
    this.shared.uniforms.range.value.set(...range);
    this.follow(state);
    this.place();
    this.scene.updateMatrixWorld(true);
    if (state.shadows) this.shadow.update(this.renderer, this.machines.flatMap((machine) => machine.shadows()), this.paint.dark);
    this.renderer.render(this.scene, this.rig.camera);
    this.compass.draw(this.renderer, this.rig.camera.matrixWorldInverse);
    this.captions.place(this.compass.ends, state.grid);
    this.drawing = false;
    this.counters.frames++;
    const passed = performance.now() - began;
    this.counters.drawMs = this.counters.drawMs ? 0.9 * this.counters.drawMs + 0.1 * passed : passed;
    const { memory } = performance as unknown as { memory?: { usedJSHeapSize: number } };
    if (memory) this.counters.heap = memory.usedJSHeapSize;
    for (const call of [...this.drawn]) call();
  }

  private frame(now: number): void {
    this.pending = 0;
    this.drawing = true;
    this.player.tick(now / 1000);
    const turning = this.rig.tick(now / 1000, matchMedia("(prefers-reduced-motion: reduce)").matches);
    this.drawNow();
    if (turning || this.store.state.playing) this.redraw();
  }

  /** Set the cameras to the content. */
  private place(): void {
    this.rig.usesPerspective = this.store.state.perspective;
    const { offset, runs } = this.store.state;
    const apart = Math.hypot(...offset) * (runs.length - 1);
    this.rig.update(this.middle, 3.4 * this.radius + apart);
    const { uniforms } = this.shared;
    uniforms.parallel.value = !this.rig.usesPerspective;
    uniforms.sky.value.copy(this.rig.above).transformDirection(this.rig.camera.matrixWorldInverse);
  }

  private applyLooks(state: Readonly<State>): void {
    if (!this.looksChanged) return;
    this.looksChanged = false;
    const { uniforms } = this.shared;
    uniforms.measure.value = measureNumber(state.measure);
    uniforms.bands.value = state.bands;
    uniforms.isolines.value = state.isolines;
    uniforms.plain.value = state.flat;
    uniforms.amplification.value = state.amplification;
    const normal = new THREE.Vector3(...state.clip.normal).normalize();
    const at = normal.dot(this.middle) + state.clip.offset * this.radius;
    uniforms.plane.value.set(normal.x, normal.y, normal.z, state.clip.on ? at : NOWHERE);
    this.shared.setMap(state.map);
    this.grid.mesh.visible = state.grid;
    this.shadow.mesh.visible = state.shadows;
    for (const machine of this.machines) machine.appear(state, this.paint);
  }

  private repaint(): void {
    this.paint = readPaint(document.documentElement);
    this.background.paint(this.paint.top, this.paint.bottom);
    this.grid.paint(this.paint.dark);
    this.shared.uniforms.unknown.value.setRGB(...(this.paint.dark ? [0.42, 0.44, 0.47] : [0.7, 0.72, 0.74]) as Vec3);
    this.looksChanged = true;
    this.redraw();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.rig.width = width;
    this.rig.height = height;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    // draw at once: a resized canvas is empty
    if (this.fitted) this.fit();
    if (this.counters.frames) this.drawNow();
  }

  private follow(state: Readonly<State>): void {
    if (!state.follow) {
      this.followed = null;
      return;
    }
    const [run, index] = state.follow.split(":").map(Number);
    const machine = this.machines[run];
    const body = machine?.run.scene.bodies[index];
    if (!body) return;
    const at = machine.position(index, 0, 0);
    if (this.followed) this.rig.target.add(new THREE.Vector3(...at).sub(new THREE.Vector3(...this.followed)));
    else this.rig.target.set(...at);
    this.followed = at;
  }

  // ---- positions in the picture ----

  /** Displayed position of a vertex in the world, m, with the amplified deformation. */
  position(run: number, body: number, vertex: number): Vec3 {
    return this.machines[run].position(body, vertex, this.store.state.amplification);
  }

  value(run: number, body: number, vertex: number): number {
    const { measure } = this.store.state;
    return measure === null ? NaN : this.machines[run].value(body, vertex, measure);
  }

  /** Position of a world point in the picture: CSS pixels and depth; null behind the camera. */
  at(point: readonly number[]): Vec3 | null {
    const x = new THREE.Vector3(...(point as Vec3)).applyMatrix4(this.rig.camera.matrixWorldInverse);
    if (this.rig.usesPerspective && x.z >= 0) return null;
    x.applyMatrix4(this.rig.camera.projectionMatrix);
    return [(0.5 + 0.5 * x.x) * this.rig.width, (0.5 - 0.5 * x.y) * this.rig.height, 0.5 + 0.5 * x.z];
  }

  project(run: number, body: number, vertex: number): Vec3 | null {
    return this.at(this.position(run, body, vertex));
  }

  /** World point at a depth under a point of the picture. */
  unproject(px: number, py: number, depth: number): Vec3 {
    const x = new THREE.Vector3((2 * px) / this.rig.width - 1, 1 - (2 * py) / this.rig.height, 2 * depth - 1);
    x.applyMatrix4(this.rig.camera.projectionMatrixInverse).applyMatrix4(this.rig.camera.matrixWorld);
    return x.toArray() as Vec3;
  }

  /** Line of sight through a point of the picture. */
  ray(px: number, py: number): { origin: Vec3; direction: Vec3 } {
    const near = new THREE.Vector3(...this.unproject(px, py, 0)), far = new THREE.Vector3(...this.unproject(px, py, 1));
    return { origin: near.toArray() as Vec3, direction: far.sub(near).normalize().toArray() as Vec3 };
  }

  pick(px: number, py: number): Hit | null {
    if (!this.counters.frames) this.drawNow();
    // apply visibility and clipping changes since the last picture
    this.applyLooks(this.store.state);
    const objects = this.machines.flatMap((machine) => machine.picks());
    const found = this.picker.find(objects, this.rig.camera, px, py, this.rig.width, this.rig.height);
    if (!found) return null;
    for (const machine of this.machines) {
      const { index: run, scene } = machine.run;
      const body = found.thing - machine.firstThing;
      if (body < 0 || body >= machine.things) continue;
      const position = this.unproject(px, py, found.depth);
      const symbol = body - scene.bodies.length, touch = symbol - scene.symbols.length;
      if (touch >= 0) return { run, body: -1, vertex: -1, position, touch };
      if (symbol >= 0) return { run, body: -1, vertex: -1, position, symbol };
      let vertex = found.vertex, least = Infinity;
      for (const candidate of machine.candidates(body, found.vertex)) {
        const at = this.project(run, body, candidate);
        const far = at ? Math.hypot(at[0] - px, at[1] - py) : Infinity;
        if (far < least) {
          least = far;
          vertex = candidate;
        }
      }
      return { run, body, vertex, position };
    }
    return null;
  }

  /** Colour of a pixel of the picture, 0 to 255. */
  pixel(px: number, py: number): Vec3 {
    this.drawNow();
    const gl = this.renderer.getContext();
    const ratio = this.renderer.getPixelRatio(), out = new Uint8Array(4);
    gl.readPixels(Math.floor(px * ratio), Math.floor((this.rig.height - py) * ratio), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, out);
    return [out[0], out[1], out[2]];
  }

  /** Ends of the axes in the corner, CSS pixels from the lower left corner, for their letters. */
  get axisEnds(): readonly (readonly [number, number])[] {
    return this.compass.ends;
  }

  // ---- the camera ----

  fit(): void {
    const { perspective, offset, runs } = this.store.state;
    this.rig.usesPerspective = perspective;
    // overlaid runs beside the first one
    const last = new THREE.Vector3(...offset).multiplyScalar(Math.max(0, runs.lastIndexOf(true)));
    const points = this.outline();
    this.rig.fit(last.lengthSq() ? [...points, ...points.map((at) => at.clone().add(last))] : points);
    this.fitted = true;
    this.followed = null;
    this.redraw();
  }

  /** Content to keep in view: bounding box of the motion, or of static shapes. */
  private outline(): THREE.Vector3[] {
    const runs = this.machines.map(({ run }) => run);
    if (!runs.every(({ track, scene }) => track instanceof StillTrack && scene.bodies.length)) return this.corners;
    const count = runs.flatMap(({ scene }) => scene.bodies).reduce((sum, body) => sum + body.positions.shape[0], 0);
    const every = Math.ceil(count / OUTLINE);
    const found = runs.flatMap(({ scene, track }) =>
      scene.bodies.flatMap((body) =>
        Array.from({ length: Math.ceil(body.positions.shape[0] / every) }, (_, k) => new THREE.Vector3(...position(body, k * every, track.row(0)))),
      ),
    );
    // single points have no size: include symbols and their ends
    const size = new THREE.Box3().setFromPoints(found).getSize(new THREE.Vector3()).length();
    return size > 0.1 * this.radius ? found : this.corners;
  }

  look(direction: Direction): void {
    this.rig.look(direction);
    this.redraw();
  }

  focus(point: readonly number[]): void {
    this.rig.target.set(...(point as Vec3));
    this.fitted = false;
    this.redraw();
  }

  // ---- colours ----

  /** CSS colour of a value of the measure. */
  colour(value: number): string {
    const { range, map } = this.store.state;
    if (!range || Number.isNaN(value)) return "gray";
    const share = (value - range[0]) / Math.max(range[1] - range[0], 1e-300);
    return `rgb(${colourAt(map, share).map(Math.round).join(" ")})`;
  }

  /** CSS colour of a body without a measure. */
  bodyColour(run: number, body: number): string {
    const { scene } = this.machines[run].run;
    return bodyColour(this.store.state, run, body, scene.bodies[body]);
  }

  // ---- pictures ----

  /** PNG of the view, `scale` picture pixels per CSS pixel. */
  async picture(scale: number, options: { transparent?: boolean } = {}): Promise<Blob> {
    const ratio = this.renderer.getPixelRatio();
    this.background.mesh.visible = !options.transparent;
    this.renderer.setPixelRatio(scale);
    this.renderer.setSize(this.rig.width, this.rig.height, false);
    this.drawNow();
    const made = new Promise<Blob>((resolve, reject) =>
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("The browser makes no picture of this size."))), "image/png"),
    );
    this.background.mesh.visible = true;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(this.rig.width, this.rig.height, false);
    this.drawNow();
    return made;
  }

  stream(fps: number): MediaStream {
    return this.canvas.captureStream(fps);
  }

  // ---- subscribers ----

  /** Subscribe to pictures; returns the function that unsubscribes. */
  onDraw(call: () => void): () => void {
    this.drawn.add(call);
    return () => this.drawn.delete(call);
  }

  onClick(call: (click: Click) => void): () => void {
    return this.mouse.onClick(call);
  }

  onDrag(call: (drag: Drag) => void): () => void {
    return this.mouse.onDrag(call);
  }
}

function openRenderer(): THREE.WebGLRenderer {
  try {
    return new THREE.WebGLRenderer({ antialias: true, alpha: true, powerPreference: "high-performance" });
  } catch {
    throw new Error("This browser draws no 3D pictures here: WebGL 2 is switched off, or its graphics driver is not supported.");
  }
}

/** Corners of the common bounding box of all runs. */
function bounds(runs: Run[]): [THREE.Vector3, THREE.Vector3] {
  const box = new THREE.Box3();
  for (const { scene } of runs) {
    box.expandByPoint(new THREE.Vector3(...scene.box[0]));
    box.expandByPoint(new THREE.Vector3(...scene.box[1]));
  }
  return [box.min, box.max];
}

function corners(low: THREE.Vector3, high: THREE.Vector3): THREE.Vector3[] {
  const out: THREE.Vector3[] = [];
  for (let i = 0; i < 8; i++) {
    out.push(new THREE.Vector3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z));
  }
  return out;
}
