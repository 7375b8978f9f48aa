/** Body in the picture: surface, edges and lines, deformed on the GPU. */

import * as THREE from "three";
import { matrix } from "../math/rotation";
import type { Body } from "../protocol";
import type { Own, Shared } from "./shared";
import { extremesMaterial, lineMaterial, pickMaterial, shadowMaterial, surfaceMaterial } from "./shared";
import { ATTRIBUTE, measureNumber } from "./measures";
import { Moves } from "./moves";
import { smooth } from "./smooth";

/** Present appearance of a body. */
export interface Appearance {
  visible: boolean;
  colour: THREE.Color;
  opacity: number;
  glow: THREE.Color | null;
  edges: boolean;
  mesh: boolean;
  line: THREE.Color;
  lineOpacity: number;
}

type Row = ArrayLike<number>;

const A = new Float64Array(9);

export class BodyView {
  readonly group = new THREE.Group();
  protected own: Own;
  protected surface: THREE.Mesh | null = null;
  protected drawn: THREE.BufferGeometry | null = null;
  private edges: THREE.LineSegments | null = null;
  private lines: THREE.LineSegments | null = null;
  private mesh: THREE.LineSegments | null = null;
  private pick: THREE.Object3D | null = null;
  private cast: THREE.Mesh | null = null;
  private vertices: THREE.Points | null = null;
  private points: THREE.BufferAttribute;
  /** Deformation and measure of its vertices. */
  readonly moves: Moves | null;

  constructor(
    readonly body: Body,
    protected shared: Shared,
    /** Number of the body in the picking picture. */
    readonly thing: number,
  ) {
    this.group.matrixAutoUpdate = false;
    this.moves = body.rings || !(this.deforms || body.stress || body.static) ? null : new Moves(body);
    this.own = this.makeOwn();
    this.points = new THREE.BufferAttribute(this.startPositions(), 3);
    this.build();
  }

  /*Whether the shader adds a deformation to the body. */
  protected get deforms(): boolean {
    return !!this.body.shapes && this.body.place >= 0;
  }

  protected startPositions(): Float32Array {
    return this.body.positions.data;
  }

  private makeOwn(): Own {
    const uniforms: Own["uniforms"] = { knows: { value: 2 } };
    const defines: Own["defines"] = {};
    if (this.moves) {
      defines["MOVED"] = 1;
      uniforms["moved"] = { value: this.moves.texture };
      uniforms["unit"] = this.moves.unit;
    }
    return { uniforms, defines };
  }

  private build(): void {
    const { body, shared, own } = this;
    if (body.triangles?.data.length) {
      const surface = smooth(this.points.array as Float32Array, body.triangles.data);
      const geometry = new THREE.BufferGeometry();
      const at = new Float32Array(3 * surface.source.length);
      surface.source.forEach((v, i) => {
        for (let k = 0; k < 3; k++) at[3 * i + k] = this.points.array[3 * v + k];
      });
      geometry.setAttribute("position", new THREE.BufferAttribute(at, 3));
      geometry.setAttribute("normal", new THREE.BufferAttribute(surface.normals, 3));
      const source = new THREE.BufferAttribute(surface.source, 1);
      (source as unknown as { gpuType: number }).gpuType = THREE.IntType;
      geometry.setAttribute("source", source);
      if (body.known) geometry.setAttribute("known", new THREE.BufferAttribute(Float32Array.from(surface.source, (v) => body.known!.data[v]), 1));
      if (body.damage) geometry.setAttribute("value", new THREE.BufferAttribute(Float32Array.from(surface.source, (v) => body.damage!.data[v]), 1));
      geometry.setIndex(new THREE.BufferAttribute(surface.index, 1));
      this.surface = new THREE.Mesh(geometry, surfaceMaterial(shared, own, this.deforms));
      this.drawn = geometry;
      this.add(this.surface);
    }
    if (body.edges?.data.length) {
      this.edges = this.segments(body.edges.data, 3e-5, false);
    }
    if (body.lines?.data.length) {
      this.lines = this.segments(body.lines.data, 0, true);
    }
  }

  private add(object: THREE.Object3D): void {
    object.frustumCulled = false;
    object.matrixAutoUpdate = false;
    this.group.add(object);
  }

  private segments(index: Uint32Array, nearer: number, coloured: boolean): THREE.LineSegments {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", this.points);
    if (this.body.known) geometry.setAttribute("known", new THREE.BufferAttribute(Float32Array.from(this.body.known.data), 1));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    const material = lineMaterial(this.shared, this.own, nearer, coloured);
    const lines = new THREE.LineSegments(geometry, material);
    this.add(lines);
    return lines;
  }

  /** Set the pose and the modal coordinates of the body. */
  update(row: Row, measure: string | null): void {
    const { body } = this;
    this.setKnown(measure);
    this.moves?.take(row, measureNumber(measure));
    if (body.place < 0) return;
    matrix(row, body.place + 3, A);
    this.group.matrix.set(
      A[0], A[1], A[2], row[body.place],
      A[3], A[4], A[5], row[body.place + 1],
      A[6], A[7], A[8], row[body.place + 2],
      0, 0, 0, 1,
    );
  }

  private setKnown(measure: string | null): void {
    const { body } = this;
    const number = measureNumber(measure);
    let knows = 0;
    if (number === 10) knows = body.rings ? 0 : 2;
    else if (number === ATTRIBUTE) knows = measure === "damage" && body.damage ? 2 : 0;
    else if (number >= 0) knows = body.stress || body.static || (body.rings && body.rings.forces >= 0) ? 1 : 0;
    this.own.uniforms["knows"].value = knows;
  }

  appear(look: Appearance): void {
    this.group.visible = look.visible;
    const see = look.opacity < 1;
    if (this.surface) {
      const material = this.surface.material as THREE.ShaderMaterial;
      (material.uniforms["colour"].value as THREE.Color).copy(look.colour);
      material.uniforms["opacity"].value = look.opacity;
      (material.uniforms["glow"].value as THREE.Color).copy(look.glow ?? NONE);
      material.transparent = see;
      material.depthWrite = !see;
    }
    if (look.mesh && !this.mesh && this.body.triangles) this.mesh = this.segments(sides(this.body.triangles.data), 2e-5, false);
    if (this.mesh) {
      this.mesh.visible = look.mesh;
      this.paint(this.mesh, look.line, 0.45 * look.lineOpacity);
    }
    if (this.edges) {
      this.edges.visible = look.edges;
      this.paint(this.edges, look.line, look.lineOpacity * (see ? 0.5 : 1));
    }
    if (this.lines) this.paint(this.lines, this.surface ? look.line : look.colour, look.opacity);
  }

  private paint(lines: THREE.LineSegments, colour: THREE.Color, opacity: number): void {
    const material = lines.material as THREE.ShaderMaterial;
    (material.uniforms["colour"].value as THREE.Color).copy(colour);
    material.uniforms["opacity"].value = opacity;
    material.transparent = opacity < 1;
  }

  /** Object for the picking picture. */
  pickObject(): THREE.Object3D {
    if (!this.pick) {
      const drawn = this.surface ?? this.lines;
      if (!drawn) this.pick = new THREE.Group();
      else {
        const material = pickMaterial(this.shared, this.own, this.thing, drawn === this.surface);
        this.pick = this.surface ? new THREE.Mesh(drawn.geometry, material) : new THREE.LineSegments(drawn.geometry, material);
      }
      this.pick.frustumCulled = false;
      this.pick.matrixAutoUpdate = this.pick.matrixWorldAutoUpdate = false;
      this.pick.matrixWorld = this.group.matrixWorld;
    }
    this.pick.visible = this.group.visible;
    return this.pick;
  }

  /** Shadow-casting object; null for lines and transparent bodies. */
  shadowObject(): THREE.Object3D | null {
    if (!this.surface || !this.group.visible || (this.surface.material as THREE.ShaderMaterial).transparent) return null;
    if (!this.cast) {
      this.cast = new THREE.Mesh(this.surface.geometry, shadowMaterial(this.shared, this.own));
      this.cast.frustumCulled = false;
      this.cast.matrixAutoUpdate = this.cast.matrixWorldAutoUpdate = false;
      this.cast.matrixWorld = this.group.matrixWorld;
    }
    return this.cast;
  }

  /** Whether the measure is known anywhere on the body. */
  get knows(): boolean {
    return this.own.uniforms["knows"].value !== 0;
  }

  /** Object for the search of the lowest and highest value. */
  probe(): THREE.Object3D {
    if (!this.vertices) {
      const drawn = this.surface ?? this.lines;
      if (!drawn) return new THREE.Group();
      // each vertex once: vertex attributes without index
      const geometry = new THREE.BufferGeometry();
      for (const [name, attribute] of Object.entries(drawn.geometry.attributes)) geometry.setAttribute(name, attribute);
      this.vertices = new THREE.Points(geometry, extremesMaterial(this.shared, this.own, drawn === this.surface));
      this.vertices.frustumCulled = false;
    }
    return this.vertices;
  }

  protected moved(): void {
    this.points.needsUpdate = true;
  }

  protected get corners(): Float32Array {
    return this.points.array as Float32Array;
  }

  dispose(): void {
    for (const object of this.group.children as THREE.Mesh[]) {
      object.geometry.dispose();
      (object.material as THREE.Material).dispose();
    }
    this.moves?.dispose();
  }
}

const NONE = new THREE.Color(0, 0, 0);

/** Unique edges of triangles. */
export function sides(triangles: Uint32Array): Uint32Array {
  const seen = new Set<number>();
  const out: number[] = [];
  const count = triangles.reduce((a, b) => Math.max(a, b), 0) + 1;
  for (let t = 0; t < triangles.length; t += 3) {
    for (let i = 0; i < 3; i++) {
      const a = triangles[t + i], b = triangles[t + ((i + 1) % 3)];
      const name = a < b ? a * count + b : b * count + a;
      if (seen.has(name)) continue;
      seen.add(name);
      out.push(a, b);
    }
  }
  return Uint32Array.from(out);
}
