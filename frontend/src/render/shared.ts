/** Uniforms shared by all materials, and the materials of surfaces and lines. */

import * as THREE from "three";
import { EXTREMES_LANES } from "./extremes";
import { EXTREMES_FRAGMENT, EXTREMES_VERTEX, LINE_FRAGMENT, LINE_VERTEX, PICK_FRAGMENT, PICK_VERTEX, SHADOW_FRAGMENT, SURFACE_FRAGMENT, SURFACE_VERTEX } from "./shader";
import { ramp } from "./maps";

/** Clipping plane without effect. */
export const NOWHERE = 3e38;

export class Shared {
  readonly uniforms = {
    measure: { value: -1 },
    range: { value: new THREE.Vector2(0, 1) },
    bands: { value: 0 },
    isolines: { value: false },
    plain: { value: false },
    parallel: { value: false },
    unknown: { value: new THREE.Color(0.62, 0.64, 0.66) },
    map: { value: null as THREE.Texture | null },
    plane: { value: new THREE.Vector4(0, 0, 1, NOWHERE) },
    sky: { value: new THREE.Vector3(0, 1, 0) },
    amplification: { value: 1 },
  };
  private shown = "";

  setMap(name: string): void {
    if (name === this.shown) return;
    this.shown = name;
    this.uniforms.map.value?.dispose();
    const data = new Uint8Array(4 * 256);
    ramp(name, 256).forEach((colour, i) => data.set([...colour.map(Math.round), 255], 4 * i));
    const texture = new THREE.DataTexture(data, 256, 1);
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    this.uniforms.map.value = texture;
  }
}

type Uniforms = Record<string, THREE.IUniform>;

/** Uniforms of a body beside the shared ones. */
export interface Own {
  uniforms: Uniforms;
  defines: Record<string, string | number>;
}

const colour = (): Uniforms => ({
  colour: { value: new THREE.Color() },
  opacity: { value: 1 },
  glow: { value: new THREE.Color(0, 0, 0) },
});

function shader(shared: Shared, own: Own, vertexShader: string, fragmentShader: string, more: Uniforms): THREE.ShaderMaterial {
  const material = new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader,
    fragmentShader,
    uniforms: { ...shared.uniforms, ...own.uniforms, ...more },
    defines: own.defines,
  });
  (material as unknown as { defaultAttributeValues: Record<string, number[]> }).defaultAttributeValues = {
    known: [1],
    value: [0],
    normal: [0, 0, 1],
  };
  return material;
}

export function surfaceMaterial(shared: Shared, own: Own, deforms: boolean): THREE.ShaderMaterial {
  const split = { ...own, defines: { ...own.defines, SPLIT: 1 } };
  const material = shader(shared, split, SURFACE_VERTEX, SURFACE_FRAGMENT, { ...colour(), deforms: { value: deforms } });
  material.side = THREE.DoubleSide;
  material.polygonOffset = true;
  material.polygonOffsetFactor = 1;
  material.polygonOffsetUnits = 1;
  return material;
}

export function lineMaterial(shared: Shared, own: Own, nearer: number, coloured: boolean): THREE.ShaderMaterial {
  const more: Uniforms = { ...colour(), nearer: { value: nearer } };
  if (!coloured) more["measure"] = { value: -1 };
  return shader(shared, own, LINE_VERTEX, LINE_FRAGMENT, more);
}

export function pickMaterial(shared: Shared, own: Own, thing: number, split: boolean): THREE.ShaderMaterial {
  const defines = split ? { ...own.defines, SPLIT: 1 } : own.defines;
  const material = shader(shared, { ...own, defines }, PICK_VERTEX, PICK_FRAGMENT, { thing: { value: thing } });
  material.side = THREE.DoubleSide;
  material.blending = THREE.NoBlending;
  return material;
}

export function extremesMaterial(shared: Shared, own: Own, split: boolean): THREE.ShaderMaterial {
  const defines = split ? { ...own.defines, SPLIT: 1 } : own.defines;
  const lanes = { lanes: { value: EXTREMES_LANES } };
  const material = shader(shared, { ...own, defines }, EXTREMES_VERTEX, EXTREMES_FRAGMENT, lanes);
  material.depthTest = material.depthWrite = false;
  material.blending = THREE.CustomBlending;
  material.blendEquation = THREE.MaxEquation;
  material.blendSrc = material.blendDst = THREE.OneFactor;
  return material;
}

/** Material of a shadow: constant 1 inside. */
export function shadowMaterial(shared: Shared, own: Own): THREE.ShaderMaterial {
  const defines = { ...own.defines, SPLIT: 1, SHADOW: 1 };
  const material = shader(shared, { ...own, defines }, PICK_VERTEX, SHADOW_FRAGMENT, {});
  material.side = THREE.DoubleSide;
  material.depthTest = material.depthWrite = false;
  return material;
}
