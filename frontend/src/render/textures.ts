/** Modal displacements and stresses as textures: one layer per mode. */

import * as THREE from "three";
import type { Block, Body } from "../protocol";

const WIDTH = 4096; // texels per line; even, so that the two texels of a vertex are side by side

function layers(data: Uint16Array | Float32Array, width: number, height: number, depth: number): THREE.DataArrayTexture {
  const texture = new THREE.DataArrayTexture(data as never, width, height, depth);
  texture.format = THREE.RGBAFormat;
  texture.type = data instanceof Uint16Array ? THREE.HalfFloatType : THREE.FloatType;
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

export function size(texels: number): [number, number] {
  const width = Math.min(WIDTH, texels + (texels % 2));
  return [Math.max(2, width), Math.max(1, Math.ceil(texels / width))];
}

/** Texture of mode shapes, one texel per vertex. */
export function shapesTexture(shapes: Block<Uint16Array | Float32Array>): THREE.DataArrayTexture {
  const [n, nv] = shapes.shape;
  const [width, height] = size(nv);
  const from = shapes.data;
  const length = 4 * width * height * n;
  const data = from instanceof Uint16Array ? new Uint16Array(length) : new Float32Array(length);
  for (let j = 0; j < n; j++) {
    let at = 4 * width * height * j, k = 3 * nv * j;
    for (let v = 0; v < nv; v++, at += 4, k += 3) {
      data[at] = from[k];
      data[at + 1] = from[k + 1];
      data[at + 2] = from[k + 2];
    }
  }
  return layers(data, width, height, n);
}

/** Texture of modal stresses, two texels per vertex; the last layer is static stress. */
export interface Stresses {
  texture: THREE.DataArrayTexture;
  /** Factor of each layer. */
  scales: number[];
}

export function stressTexture(body: Body): Stresses | null {
  const modal = body.stress, still = body.static;
  if (!modal && !still) return null;
  const nv = body.positions.shape[0];
  const [width, height] = size(2 * nv);
  const layer = 4 * width * height;
  const halves = !modal || modal.data instanceof Uint16Array;
  const data = halves ? new Uint16Array(layer * (body.modes + 1)) : new Float32Array(layer * (body.modes + 1));
  if (modal) {
    for (let j = 0; j < body.modes; j++) {
      let at = layer * j, k = 6 * nv * j;
      for (let v = 0; v < nv; v++, at += 8, k += 6) {
        for (let i = 0; i < 6; i++) data[at + i] = modal.data[k + i];
      }
    }
  }
  let largest = 0;
  if (still) {
    for (const x of still.data) if (Math.abs(x) > largest) largest = Math.abs(x);
    const scale = halves && largest > 0 ? largest : 1;
    for (let v = 0, at = layer * body.modes, k = 0; v < nv; v++, at += 8, k += 6) {
      for (let i = 0; i < 6; i++) {
        const x = still.data[k + i] / scale;
        data[at + i] = halves ? THREE.DataUtils.toHalfFloat(x) : x;
      }
    }
  }
  const scales = Array.from({ length: body.modes }, (_, j) => (modal ? (body.stress_scale?.[j] ?? 1) : 0));
  scales.push(still ? (halves && largest > 0 ? largest : 1) : 0);
  return { texture: layers(data, width, height, body.modes + 1), scales };
}
