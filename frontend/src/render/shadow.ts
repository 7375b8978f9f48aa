/** Soft shadow on the floor: a blurred picture of the bodies from above. */

import * as THREE from "three";

const SIZE = 512; // pixels

const FLAT = /* glsl */ `
out vec2 uv2;
void main() { uv2 = 0.5 * position.xy + 0.5; gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

const BLUR = /* glsl */ `
precision highp float;
in vec2 uv2;
out vec4 pixel;
uniform sampler2D image;
uniform vec2 stride;
void main() {
  float sum = 0.0, weights = 0.0;
  for (int i = -7; i <= 7; i++) {
    float w = exp(-float(i * i) / 18.0);
    sum += w * texture(image, uv2 + float(i) * stride).r;
    weights += w;
  }
  pixel = vec4(sum / weights, 0.0, 0.0, 1.0);
}
`;

const FLOOR_VERTEX = /* glsl */ `
out vec2 at;
void main() {
  at = 0.5 * position.xy + 0.5;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0));
}
`;

const FLOOR_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 at;
out vec4 pixel;
uniform sampler2D image;
uniform float strength;
void main() {
  vec2 rim = smoothstep(vec2(0.0), vec2(0.08), at) * smoothstep(vec2(0.0), vec2(0.08), 1.0 - at);
  pixel = vec4(0.04, 0.06, 0.1, strength * texture(image, at).r * rim.x * rim.y);
}
`;

function target(): THREE.WebGLRenderTarget {
  return new THREE.WebGLRenderTarget(SIZE, SIZE, { depthBuffer: false, format: THREE.RedFormat, type: THREE.UnsignedByteType, generateMipmaps: false });
}

export class Shadow {
  /** Floor that receives the shadow. */
  readonly mesh: THREE.Mesh;
  private drawn = target();
  private blurred = target();
  private camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
  private scene = new THREE.Scene();
  private flat = new THREE.Scene();
  private blur: THREE.ShaderMaterial;

  constructor(up: THREE.Vector3, middle: THREE.Vector3, radius: number, floor: number) {
    const half = 1.5 * radius;
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    const foot = middle.clone().addScaledVector(up, floor - middle.dot(up) + 1e-4 * radius);
    this.mesh = new THREE.Mesh(
      new THREE.PlaneGeometry(2, 2),
      new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        vertexShader: FLOOR_VERTEX,
        fragmentShader: FLOOR_FRAGMENT,
        uniforms: { image: { value: this.drawn.texture }, strength: { value: 0.3 } },
        transparent: true,
        depthWrite: false,
      }),
    );
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = -2;
    this.mesh.matrixAutoUpdate = false;
    this.mesh.matrix.compose(foot, turn, new THREE.Vector3(half, half, 1));
    // camera far above, looking down; picture axes are the floor axes
    const { camera } = this;
    Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: 0, far: 8 * radius });
    camera.updateProjectionMatrix();
    camera.matrixAutoUpdate = false;
    camera.matrix.compose(foot.clone().addScaledVector(up, 6 * radius), turn, new THREE.Vector3(1, 1, 1));
    camera.matrixWorld.copy(camera.matrix);
    camera.matrixWorldInverse.copy(camera.matrix).invert();
    this.blur = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: FLAT,
      fragmentShader: BLUR,
      uniforms: { image: { value: null }, stride: { value: new THREE.Vector2() } },
      depthTest: false,
      depthWrite: false,
    });
    const whole = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), this.blur);
    whole.frustumCulled = false;
    this.flat.add(whole);
    this.scene.matrixWorldAutoUpdate = false;
  }

  /** Draw the shadow-casting objects. */
  update(renderer: THREE.WebGLRenderer, casting: THREE.Object3D[], dark: boolean): void {
    const material = this.mesh.material as THREE.ShaderMaterial;
    material.uniforms["strength"].value = dark ? 0.55 : 0.26;
    const colour = renderer.getClearColor(new THREE.Color()), alpha = renderer.getClearAlpha();
    renderer.setClearColor(0x000000, 1);
    this.scene.children = casting;
    renderer.setRenderTarget(this.drawn);
    renderer.render(this.scene, this.camera);
    this.scene.children = [];
    const { image, stride } = this.blur.uniforms;
    for (const [from, to, x, y] of [[this.drawn, this.blurred, 1.4, 0], [this.blurred, this.drawn, 0, 1.4]] as const) {
      image.value = from.texture;
      (stride.value as THREE.Vector2).set(x / SIZE, y / SIZE);
      renderer.setRenderTarget(to);
      renderer.render(this.flat, this.camera);
    }
    renderer.setRenderTarget(null);
    renderer.setClearColor(colour, alpha);
  }
}
