/** The axes of the world in a corner of the picture. */

import * as THREE from "three";
import { LIGHT } from "./shader";
import type { Shared } from "./shared";
import { makeShape } from "./symbols/glyphs";
import { raw } from "./appearance";

const SIDE = 76; // CSS pixels

export class Compass {
  private scene = new THREE.Scene();
  private camera = new THREE.OrthographicCamera(-1.25, 1.25, 1.25, -1.25, -5, 5);
  /** Ends of the axes, CSS pixels from the lower left corner, for their letters. */
  readonly ends: [number, number][] = [[0, 0], [0, 0], [0, 0]];

  constructor(shared: Shared) {
    const colours = ["#d64b45", "#4da352", "#4577d6"].map(raw);
    const axes = [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)];
    axes.forEach((axis, k) => {
      const material = new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        vertexShader: "out vec3 n; void main() { n = normalize(mat3(modelViewMatrix) * normal); gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0)); }",
        fragmentShader: `precision highp float; ${LIGHT} in vec3 n; out vec4 pixel; uniform vec3 colour;
          void main() { pixel = vec4(toScreen(lit(toLinear(colour), normalize(n), vec3(0.0, 0.0, 1.0), 0.2)), 1.0); }`,
        uniforms: { colour: { value: colours[k] }, sky: shared.uniforms.sky },
      });
      const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis);
      for (const [shape, from, length, radius] of [["cylinder", 0, 0.62, 0.055], ["cone", 0.62, 0.34, 0.15]] as const) {
        const mesh = new THREE.Mesh(makeShape(shape), material);
        mesh.quaternion.copy(turn);
        mesh.position.copy(axis).multiplyScalar(from);
        mesh.scale.set(radius, radius, length);
        this.scene.add(mesh);
      }
    });
  }

  draw(renderer: THREE.WebGLRenderer, view: THREE.Matrix4): void {
    const turn = new THREE.Matrix4().extractRotation(view);
    this.camera.matrixAutoUpdate = false;
    this.camera.matrix.copy(turn).invert();
    this.camera.matrixWorld.copy(this.camera.matrix);
    this.camera.matrixWorldInverse.copy(turn);
    const clears = renderer.autoClear;
    renderer.autoClear = false;
    renderer.setViewport(4, 4, SIDE, SIDE);
    renderer.clearDepth();
    renderer.render(this.scene, this.camera);
    renderer.autoClear = clears;
    const { width, height } = renderer.getSize(new THREE.Vector2());
    renderer.setViewport(0, 0, width, height);
    for (let k = 0; k < 3; k++) {
      const column = new THREE.Vector3().setFromMatrixColumn(turn, k);
      this.ends[k] = [4 + SIDE * (0.5 + (1.14 * column.x) / 2.5), 4 + SIDE * (0.5 + (1.14 * column.y) / 2.5)];
    }
  }
}
