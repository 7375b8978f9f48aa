/** Floor: a grid with round spacing that fades at its edge. */

import * as THREE from "three";

const VERTEX = /* glsl */ `
out vec2 at;
uniform float size;
void main() {
  at = position.xy * size;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(position.xy * size, 0.0, 1.0));
}
`;

const FRAGMENT = /* glsl */ `
precision highp float;
in vec2 at;
out vec4 pixel;
uniform float size;
uniform float stride;
uniform vec3 colour;
uniform float opacity;
float lines(vec2 x) {
  vec2 w = fwidth(x);
  vec2 d = abs(fract(x - 0.5) - 0.5) / max(w, vec2(1e-9));
  vec2 near = (1.0 - smoothstep(0.25, 1.0, d)) * (1.0 - smoothstep(0.25, 0.6, w));
  return max(near.x, near.y);
}
void main() {
  float fade = 1.0 - smoothstep(0.35, 1.0, length(at) / size);
  float fine = lines(at / stride), coarse = lines(at / (5.0 * stride));
  float a = max(0.45 * fine, 0.9 * coarse) * fade * opacity;
  if (a < 0.004) discard;
  pixel = vec4(colour, a);
}
`;

/** Largest of 1, 2, 5 times a power of ten that does not exceed a number. */
export function roundStep(x: number): number {
  const ten = 10 ** Math.floor(Math.log10(x));
  const m = x / ten;
  return (m >= 5 ? 5 : m >= 2 ? 2 : 1) * ten;
}

export class Grid {
  readonly mesh: THREE.Mesh;
  /** Distance of neighbouring lines, m. */
  readonly step: number;

  constructor(up: THREE.Vector3, middle: THREE.Vector3, radius: number, floor: number) {
    this.step = roundStep(radius / 6);
    const size = 3.2 * radius;
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: {
        size: { value: size },
        stride: { value: this.step },
        colour: { value: new THREE.Color() },
        opacity: { value: 1 },
      },
      transparent: true,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    this.mesh = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = -1;
    this.mesh.matrixAutoUpdate = false;
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    // lines at multiples of the spacing in the world
    const across = new THREE.Vector3(1, 0, 0).applyQuaternion(turn), along = new THREE.Vector3(0, 1, 0).applyQuaternion(turn);
    const whole = (x: number): number => Math.round(x / (5 * this.step)) * 5 * this.step;
    const at = new THREE.Vector3()
      .addScaledVector(across, whole(middle.dot(across)))
      .addScaledVector(along, whole(middle.dot(along)))
      .addScaledVector(up, floor);
    this.mesh.matrix.compose(at, turn, new THREE.Vector3(1, 1, 1));
  }

  paint(dark: boolean): void {
    const { uniforms } = this.mesh.material as THREE.ShaderMaterial;
    (uniforms["colour"].value as THREE.Color).setRGB(...(dark ? [0.62, 0.68, 0.76] : [0.36, 0.42, 0.5]) as [number, number, number]);
    uniforms["opacity"].value = dark ? 0.24 : 0.27;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    (this.mesh.material as THREE.Material).dispose();
  }
}
