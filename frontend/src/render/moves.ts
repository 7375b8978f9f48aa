/** Vertex displacements and measure of a body: modal sums in a texture. */

import * as THREE from "three";
import type { Body } from "../protocol";
import { MOVE_FRAGMENT } from "./shader";
import { shapesTexture, size, stressTexture } from "./textures";

const camera = new THREE.Camera();

export class Moves {
  readonly unit = { value: 1 };
  private target: THREE.WebGLRenderTarget;
  private scene = new THREE.Scene();
  private p: Float32Array;
  private q: Float32Array;
  private scales: number[];
  private measure = { value: -1 };
  private changed = true;
  private stressed: boolean;

  constructor(private body: Body) {
    const nv = body.positions.shape[0];
    const [width, height] = size(nv);
    this.target = new THREE.WebGLRenderTarget(width, height, {
      type: THREE.FloatType,
      format: THREE.RGBAFormat,
      minFilter: THREE.NearestFilter,
      magFilter: THREE.NearestFilter,
      depthBuffer: false,
      generateMipmaps: false,
    });
    const stresses = stressTexture(body);
    this.stressed = !!stresses;
    this.scales = stresses?.scales ?? [];
    this.p = new Float32Array(4 * Math.max(1, Math.ceil(body.modes / 4)));
    this.q = new Float32Array(4 * Math.ceil((body.modes + 1) / 4));
    const defines: Record<string, number> = { MODES: body.modes, WIDTH: width };
    const uniforms: Record<string, THREE.IUniform> = {
      measure: this.measure,
      unit: this.unit,
      count: { value: nv },
    };
    if (body.shapes && body.place >= 0 && body.modes) {
      defines["SHAPES"] = 1;
      uniforms["shapes"] = { value: shapesTexture(body.shapes) };
      uniforms["p"] = { value: this.p };
    }
    if (stresses) {
      defines["STRESS"] = 1;
      uniforms["stresses"] = { value: stresses.texture };
      uniforms["q"] = { value: this.q };
    }
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: MOVE_FRAGMENT,
      uniforms,
      defines,
      depthTest: false,
      depthWrite: false,
      blending: THREE.NoBlending,
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
  }

  get texture(): THREE.Texture {
    return this.target.texture;
  }

  /** Set the modal coordinates from a row, and the index of the measure. */
  take(row: ArrayLike<number>, measure: number): void {
    const { body, p, q, scales } = this;
    if (measure !== this.measure.value) {
      this.measure.value = measure;
      this.changed = true;
    }
    const set = (array: Float32Array, at: number, value: number): void => {
      const rounded = Math.fround(value);
      if (array[at] === rounded) return;
      array[at] = rounded;
      this.changed = true;
    };
    let sum = 0;
    for (let j = 0; j < body.modes; j++) {
      const x = body.place >= 0 ? row[body.place + 7 + j] : 0;
      set(p, j, x * (body.shape_scale?.[j] ?? 1));
      if (this.stressed) set(q, j, x * (scales[j] ?? 0));
      sum += Math.abs(measure === 10 ? p[j] : (q[j] ?? 0));
    }
    if (this.stressed) {
      set(q, body.modes, scales[body.modes]);
      if (measure !== 10) sum += Math.abs(q[body.modes]);
    }
    // half-float stresses are scaled to at most 1, and so is the measure
    this.unit.value = sum > 0 ? sum : 1;
  }

  /** Compute the sums if the coordinates or the measure have changed. */
  draw(renderer: THREE.WebGLRenderer): void {
    if (!this.changed) return;
    this.changed = false;
    if (!renderer.extensions.has("EXT_color_buffer_float")) this.target.texture.type = THREE.HalfFloatType;
    const clears = renderer.autoClear;
    renderer.autoClear = false;
    renderer.setRenderTarget(this.target);
    renderer.render(this.scene, camera);
    renderer.setRenderTarget(null);
    renderer.autoClear = clears;
  }

  /** Recompute at the next picture. */
  forget(): void {
    this.changed = true;
  }

  dispose(): void {
    this.target.dispose();
    const { material, geometry } = this.scene.children[0] as THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
    for (const name of ["shapes", "stresses"]) (material.uniforms[name]?.value as THREE.Texture | undefined)?.dispose();
    material.dispose();
    geometry.dispose();
  }
}
