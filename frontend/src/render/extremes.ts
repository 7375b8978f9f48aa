/**
 * The lowest and highest value over the drawn vertices: each vertex is drawn as a point on one of several pixels, which store the largest
 * value drawn on them.
 */

import * as THREE from "three";

const LANES = 64; // number of pixels, so that the points need not all wait for one pixel

export class Extremes {
  private target: THREE.WebGLRenderTarget | null = null;
  private scene = new THREE.Scene();
  private camera = new THREE.Camera();
  private pixels = new Float32Array(4 * LANES);

  /** Maxima of the two probe outputs, value and -value, over all points. */
  find(renderer: THREE.WebGLRenderer, probes: THREE.Object3D[]): [number, number] | null {
    if (!probes.length) return null;
    if (!this.target) {
      const gl = renderer.getContext();
      // render targets with blendable floats
      if (!gl.getExtension("EXT_color_buffer_float") || !gl.getExtension("EXT_float_blend")) return null;
      this.target = new THREE.WebGLRenderTarget(LANES, 1, { type: THREE.FloatType, depthBuffer: false, generateMipmaps: false });
    }
    this.scene.children = probes;
    const colour = renderer.getClearColor(new THREE.Color()), alpha = renderer.getClearAlpha();
    renderer.setRenderTarget(this.target);
    const gl = renderer.getContext() as WebGL2RenderingContext;
    gl.clearBufferfv(gl.COLOR, 0, [-3e38, -3e38, 0, 0]);
    const clears = renderer.autoClear;
    renderer.autoClear = false;
    renderer.render(this.scene, this.camera);
    renderer.autoClear = clears;
    gl.readPixels(0, 0, LANES, 1, gl.RGBA, gl.FLOAT, this.pixels);
    renderer.setRenderTarget(null);
    renderer.setClearColor(colour, alpha);
    this.scene.children = [];
    let low = -3e38, high = -3e38;
    for (let i = 0; i < LANES; i++) {
      high = Math.max(high, this.pixels[4 * i]);
      low = Math.max(low, this.pixels[4 * i + 1]);
    }
    return high > -2e38 ? [-low, high] : null;
  }
}

export const EXTREMES_LANES = LANES;
