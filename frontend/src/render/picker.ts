/** Object under a point of the picture, from a one-pixel rendering of object numbers. */

import * as THREE from "three";

export interface Found {
  thing: number;
  /** Vertex of the triangle that was hit. */
  vertex: number;
  /** Depth 0 to 1. */
  depth: number;
}

const REACH = 3; // distance from the point, pixels, within which thin objects are found

export class Picker {
  private side = 2 * REACH + 1;
  private target: THREE.WebGLRenderTarget;
  private scene = new THREE.Scene();
  private pixels: Uint32Array;

  constructor(private renderer: THREE.WebGLRenderer) {
    this.target = new THREE.WebGLRenderTarget(this.side, this.side, {
      format: THREE.RGBAIntegerFormat,
      type: THREE.UnsignedIntType,
      internalFormat: "RGBA32UI",
      minFilter: THREE.NearestFilter,
      magFilter: THREE.NearestFilter,
      depthBuffer: true,
      generateMipmaps: false,
    });
    this.pixels = new Uint32Array(4 * this.side ** 2);
    this.scene.matrixAutoUpdate = false;
  }

  /** Draw the objects around a point (CSS pixels of a picture of given size) and read the pixel. */
  find(objects: THREE.Object3D[], camera: THREE.PerspectiveCamera | THREE.OrthographicCamera, x: number, y: number, width: number, height: number): Found | null {
    const { renderer, side } = this;
    this.scene.children = objects;
    camera.setViewOffset(width, height, x - side / 2, y - side / 2, side, side);
    const alpha = renderer.getClearAlpha();
    renderer.setRenderTarget(this.target);
    const gl = renderer.getContext() as WebGL2RenderingContext;
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    renderer.clearDepth();
    const clears = renderer.autoClear;
    renderer.autoClear = false;
    renderer.render(this.scene, camera);
    renderer.autoClear = clears;
    gl.readPixels(0, 0, side, side, gl.RGBA_INTEGER, gl.UNSIGNED_INT, this.pixels);
    renderer.setRenderTarget(null);
    renderer.setClearAlpha(alpha);
    camera.clearViewOffset();
    this.scene.children = [];
    return this.nearest();
  }

  private nearest(): Found | null {
    let best: Found | null = null, least = Infinity;
    const bits = new Uint32Array(1), float = new Float32Array(bits.buffer);
    for (let row = 0; row < this.side; row++) {
      for (let column = 0; column < this.side; column++) {
        const at = 4 * (row * this.side + column);
        if (!this.pixels[at]) continue;
        const far = Math.hypot(row - REACH, column - REACH);
        if (far >= least) continue;
        least = far;
        bits[0] = this.pixels[at + 2];
        best = { thing: this.pixels[at] - 1, vertex: this.pixels[at + 1], depth: float[0] };
      }
    }
    return best;
  }

  dispose(): void {
    this.target.dispose();
  }
}

/** Triangles around each vertex, for the nearest corner of the hit triangle. */
export class Neighbours {
  private from: Uint32Array;
  private around: Uint32Array;

  constructor(
    private triangles: Uint32Array,
    vertices: number,
  ) {
    this.from = new Uint32Array(vertices + 1);
    for (const v of triangles) this.from[v + 1]++;
    for (let v = 0; v < vertices; v++) this.from[v + 1] += this.from[v];
    this.around = new Uint32Array(triangles.length);
    const next = this.from.slice();
    triangles.forEach((v, corner) => (this.around[next[v]++] = Math.floor(corner / 3)));
  }

  /** Vertices that share a triangle with a vertex, and itself. */
  of(vertex: number): Set<number> {
    const out = new Set([vertex]);
    for (let k = this.from[vertex]; k < this.from[vertex + 1]; k++) {
      for (let i = 0; i < 3; i++) out.add(this.triangles[3 * this.around[k] + i]);
    }
    return out;
  }
}
