/** Background of the picture: a vertical gradient. */

import * as THREE from "three";

export class Background {
  readonly mesh: THREE.Mesh;

  constructor() {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: "out float up; void main() { up = 0.5 * position.y + 0.5; gl_Position = vec4(position.xy, 1.0, 1.0); }",
      fragmentShader: /* glsl */ `
        precision highp float;
        in float up;
        out vec4 pixel;
        uniform vec3 top;
        uniform vec3 bottom;
        void main() {
          // noise hides the steps of the gradient
          float noise = fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5;
          pixel = vec4(mix(bottom, top, up) + noise / 255.0, 1.0);
        }`,
      uniforms: { top: { value: new THREE.Color() }, bottom: { value: new THREE.Color() } },
      depthTest: false,
      depthWrite: false,
    });
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = -10;
  }

  paint(top: THREE.Color, bottom: THREE.Color): void {
    const { uniforms } = this.mesh.material as THREE.ShaderMaterial;
    (uniforms["top"].value as THREE.Color).copy(top);
    (uniforms["bottom"].value as THREE.Color).copy(bottom);
  }
}
