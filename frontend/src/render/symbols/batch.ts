/** All pieces of one shape in one draw call, faint where bodies hide them. */

import * as THREE from "three";
import { LIGHT } from "../shader";
import type { Shared } from "../shared";
import type { Shape } from "./glyphs";
import { COILS, makeShape } from "./glyphs";

const PLACE = /* glsl */ `
#ifdef COIL
const float TURNS = float(${COILS});
// position: place along the wire, cosine and sine around it
void bend(out vec3 x, out vec3 n, mat4 M) {
  float R = length(M[0].xyz), L = length(M[2].xyz);
  float angle = 6.2831853 * TURNS * position.x;
  vec3 c = vec3(R * cos(angle), R * sin(angle), L * position.x);
  vec3 t = normalize(vec3(-sin(angle) * R, cos(angle) * R, L / (6.2831853 * TURNS)));
  vec3 a = vec3(-cos(angle), -sin(angle), 0.0), b = cross(t, a);
  n = position.y * a + position.z * b;
  vec3 at = c + 0.17 * R * n;
  mat3 Q = mat3(M[0].xyz / R, M[1].xyz / R, M[2].xyz / max(L, 1e-30));
  x = Q * at + M[3].xyz;
  n = Q * n;
}
#else
void bend(out vec3 x, out vec3 n, mat4 M) {
  x = (M * vec4(position, 1.0)).xyz;
  // normal matrix of a scaled rotation: columns of M over their squared lengths
  n = M[0].xyz * (normal.x / dot(M[0], M[0])) + M[1].xyz * (normal.y / dot(M[1], M[1])) + M[2].xyz * (normal.z / dot(M[2], M[2]));
}
#endif
`;

const VERTEX = /* glsl */ `
in vec3 tint;
out vec3 vView;
out vec3 vNormal;
out vec3 vTint;
${PLACE}
void main() {
  vec3 x, n;
  bend(x, n, instanceMatrix);
  vec4 view = modelViewMatrix * vec4(x, 1.0);
  vView = view.xyz;
  vNormal = mat3(modelViewMatrix) * n;
  vTint = tint;
  gl_Position = projectionMatrix * view;
}
`;

const FRAGMENT = /* glsl */ `
precision highp float;
${LIGHT}
uniform float opacity;
uniform bool parallel;
in vec3 vView;
in vec3 vNormal;
in vec3 vTint;
out vec4 pixel;
void main() {
  vec3 eye = parallel ? vec3(0.0, 0.0, 1.0) : normalize(-vView);
  vec3 n = normalize(vNormal);
  if (dot(n, eye) < 0.0) n = -n;
  pixel = vec4(toScreen(lit(toLinear(vTint), n, eye, 0.2)), opacity);
}
`;

const PICK_VERTEX = /* glsl */ `
in uint tag;
flat out uint vTag;
${PLACE}
void main() {
  vec3 x, n;
  bend(x, n, instanceMatrix);
  vTag = tag;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(x, 1.0));
}
`;

const PICK = /* glsl */ `
precision highp float;
precision highp int;
flat in uint vTag;
out uvec4 found;
void main() {
  found = uvec4(vTag + 1u, 0u, floatBitsToUint(gl_FragCoord.z), 1u);
}
`;

export class Batch {
  readonly solid: THREE.InstancedMesh;
  /** Faint pieces behind bodies. */
  readonly hidden: THREE.InstancedMesh;
  readonly pick: THREE.InstancedMesh;
  private tints: THREE.InstancedBufferAttribute;
  private tags: THREE.InstancedBufferAttribute;
  count = 0;

  constructor(shape: Shape, shared: Shared, capacity: number) {
    const geometry = makeShape(shape);
    this.tints = new THREE.InstancedBufferAttribute(new Float32Array(3 * capacity), 3);
    this.tags = new THREE.InstancedBufferAttribute(new Uint32Array(capacity), 1);
    (this.tags as unknown as { gpuType: number }).gpuType = THREE.IntType;
    geometry.setAttribute("tint", this.tints);
    geometry.setAttribute("tag", this.tags);
    const make = (vertexShader: string, fragmentShader: string, opacity: number): THREE.ShaderMaterial =>
      new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        vertexShader,
        fragmentShader,
        uniforms: { ...shared.uniforms, opacity: { value: opacity } },
        defines: shape === "coil" ? { COIL: 1 } : {},
        transparent: opacity < 1,
      });
    const drawn = make(VERTEX, FRAGMENT, 1);
    this.solid = new THREE.InstancedMesh(geometry, drawn, capacity);
    const faint = make(VERTEX, FRAGMENT, 0.3);
    faint.depthFunc = THREE.GreaterDepth;
    faint.depthWrite = false;
    this.hidden = new THREE.InstancedMesh(geometry, faint, capacity);
    this.hidden.renderOrder = 5;
    const found = make(PICK_VERTEX, PICK, 1);
    found.blending = THREE.NoBlending;
    this.pick = new THREE.InstancedMesh(geometry, found, capacity);
    this.hidden.instanceMatrix = this.pick.instanceMatrix = this.solid.instanceMatrix;
    this.solid.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    for (const mesh of [this.solid, this.hidden, this.pick]) {
      mesh.frustumCulled = false;
      mesh.matrixAutoUpdate = false;
      mesh.count = 0;
    }
  }

  begin(): void {
    this.count = 0;
  }

  add(matrix: THREE.Matrix4, tint: THREE.Color, tag: number): void {
    if (this.count >= this.tags.count) return;
    this.solid.setMatrixAt(this.count, matrix);
    this.tints.setXYZ(this.count, tint.r, tint.g, tint.b);
    this.tags.setX(this.count, tag);
    this.count++;
  }

  end(): void {
    for (const mesh of [this.solid, this.hidden, this.pick]) mesh.count = this.count;
    this.solid.instanceMatrix.needsUpdate = true;
    this.tints.needsUpdate = this.tags.needsUpdate = true;
  }

  dispose(): void {
    this.solid.geometry.dispose();
    for (const mesh of [this.solid, this.hidden, this.pick]) {
      (mesh.material as THREE.Material).dispose();
      mesh.dispose();
    }
  }
}
