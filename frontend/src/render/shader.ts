/** GPU programs: deformation, stress, colours, light. */

/**
 * Deformation and measure of each vertex, computed once for all objects drawn with them, one pixel per vertex.
 * Textures have one layer per mode; textures of stress have two texels per vertex. Defines: MODES, SHAPES (there
 * are shapes), STRESS (modal or static stress).
 */
export const MOVE_FRAGMENT = /* glsl */ `
precision highp float;
precision highp int;
uniform int measure;
uniform float unit;                    // unit of the measure, in which half floats can represent it
uniform int count;
#ifdef SHAPES
uniform highp sampler2DArray shapes;
uniform vec4 p[(MODES + 3) / 4];       // times the scale of each mode
#endif
#ifdef STRESS
uniform highp sampler2DArray stresses;
uniform vec4 q[(MODES + 4) / 4];       // times the scale of each mode; the last one is of static stress
#endif
layout(location = 0) out vec4 moved;

// see math/tensor.ts; scaled so that cubes stay within the float range
vec2 principal(vec3 d, vec3 s) {
  float mean = (d.x + d.y + d.z) / 3.0;
  vec3 a = d - mean;
  float size = max(max(max(abs(a.x), abs(a.y)), abs(a.z)), max(max(abs(s.x), abs(s.y)), abs(s.z)));
  if (size == 0.0) return vec2(mean);
  a /= size;
  vec3 t = s / size;
  float k = sqrt((dot(a, a) + 2.0 * dot(t, t)) / 6.0);
  float third = a.x * (a.y * a.z - t.y * t.y) - t.x * (t.x * a.z - t.y * t.z)
              + t.z * (t.x * t.y - a.y * t.z);
  float angle = acos(clamp(third / (2.0 * k * k * k), -1.0, 1.0)) / 3.0;
  return mean + 2.0 * k * size * vec2(cos(angle), cos(angle + 2.0943951));
}

#ifdef STRESS
float judged(int v) {
  vec3 d = vec3(0.0), s = vec3(0.0);
  int width = textureSize(stresses, 0).x;
  ivec2 at = ivec2((2 * v) % width, (2 * v) / width);
  for (int j = 0; j <= MODES; j++) {
    float f = q[j >> 2][j & 3];
    if (f == 0.0) continue;
    vec4 a = texelFetch(stresses, ivec3(at, j), 0);
    vec2 b = texelFetch(stresses, ivec3(at.x + 1, at.y, j), 0).xy;
    d += f * a.xyz;
    s += f * vec3(a.w, b);
  }
  if (measure < 3) return d[measure];
  if (measure < 6) return s[measure - 3];
  vec3 e = d - d.yzx;
  float mises = sqrt(0.5 * dot(e, e) + 3.0 * dot(s, s));
  if (measure == 6) return mises;
  vec2 w = principal(d, s);
  // pure shear: the sum is a rounding error of single precision
  if (measure == 7) return w.x + w.y >= -1e-4 * (w.x - w.y) ? mises : -mises;
  return measure == 8 ? w.x : w.y;
}
#endif

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 u = vec3(0.0);
  float x = 0.0;
#ifdef SHAPES
  for (int j = 0; j < MODES; j++) {
    float f = p[j >> 2][j & 3];
    if (f != 0.0) u += f * texelFetch(shapes, ivec3(at, j), 0).xyz;
  }
#endif
#ifdef STRESS
  int v = at.y * WIDTH + at.x;
  if (measure >= 0 && measure < 10 && v < count) x = judged(v);
#endif
  if (measure == 10) x = length(u);
  moved = vec4(u, x / unit);
}
`;

/**
 * Code shared by the vertex shaders. Defines: MOVED (there is a texture of deformations), SPLIT (the corners of a vertex at a crease are
 * separate, and an attribute contains the number of the vertex).
 */
export const DEFORM = /* glsl */ `
uniform int measure;
uniform int knows;                     // 0: known nowhere, 1: known at some vertices, 2: known everywhere
in float known;
in float value;                        // values computed by the processor: beams, damage
#ifdef SPLIT
in uint source;
#endif
#ifdef MOVED
uniform highp sampler2D moved;
uniform float unit;
#endif
int vertexNumber() {
#ifdef SPLIT
  return int(source);
#else
  return gl_VertexID;
#endif
}

// deformation and measure
vec4 movedBy(int v) {
#ifdef MOVED
  int width = textureSize(moved, 0).x;
  vec4 found = texelFetch(moved, ivec2(v % width, v / width), 0);
  return vec4(found.xyz, measure == 11 ? value : unit * found.w);
#else
  return vec4(0.0, 0.0, 0.0, measure == 10 ? 0.0 : value);
#endif
}
`;

export const SURFACE_VERTEX = /* glsl */ `
${DEFORM}
uniform float amplification;
out vec3 vView;
out vec3 vNormal;
out vec3 vMoved;
out vec3 vWorld;
out float vValue;
out float vKnown;

void main() {
  int v = vertexNumber();
  vec4 moves = movedBy(v);
  vec3 u = moves.xyz;
  vec3 x = position + amplification * u;
  vec4 view = modelViewMatrix * vec4(x, 1.0);
  vView = view.xyz;
  vNormal = mat3(modelViewMatrix) * normal;
  vMoved = mat3(modelViewMatrix) * (amplification * u);
  vWorld = (modelMatrix * vec4(x, 1.0)).xyz;
  vKnown = knows == 1 ? known : float(knows);
  vValue = moves.w;
  gl_Position = projectionMatrix * view;
}
`;

export const CLIP = /* glsl */ `
uniform vec4 plane;      // normal and distance, world; w > 1e30: none
bool cutAway(vec3 x) { return plane.w < 1e30 && dot(plane.xyz, x) > plane.w; }
`;

export const LIGHT = /* glsl */ `
uniform vec3 sky;        // direction up, view
vec3 toLinear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 toScreen(vec3 c) { return mix(12.92 * c, 1.055 * pow(max(c, 0.0), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
// lights: large soft one above, key light upper left of the viewer, weak one from the right
vec3 lit(vec3 colour, vec3 n, vec3 eye, float gloss) {
  vec3 key = normalize(vec3(-0.45, 0.65, 0.75));
  vec3 weak = normalize(vec3(0.8, -0.1, 0.4));
  float d = max(dot(n, key), 0.0);
  float ambient = 0.5 + 0.5 * dot(n, sky);
  float light = 0.40 + 0.26 * ambient + 0.50 * d + 0.12 * max(dot(n, weak), 0.0);
  vec3 h = normalize(key + eye);
  float shine = gloss * pow(max(dot(n, h), 0.0), 36.0);
  float rim = gloss * 0.35 * pow(1.0 - max(dot(n, eye), 0.0), 4.0);
  return colour * light + vec3(shine + rim * ambient);
}
`;

export const SURFACE_FRAGMENT = /* glsl */ `
precision highp float;
${CLIP}
${LIGHT}
uniform vec3 colour;
uniform float opacity;
uniform int measure;
uniform vec2 range;
uniform float bands;
uniform bool isolines;
uniform bool plain;      // colours of the map, without light
uniform bool deforms;
uniform bool parallel;
uniform vec3 unknown;
uniform vec3 glow;       // colour added to a selected body
uniform sampler2D map;
in vec3 vView;
in vec3 vNormal;
in vec3 vMoved;
in vec3 vWorld;
in float vValue;
in float vKnown;
out vec4 pixel;

void main() {
  vec3 dx = dFdx(vView), dy = dFdy(vView);
  vec3 mx = dFdx(vMoved), my = dFdy(vMoved);
  float slope = fwidth(vValue);
  if (cutAway(vWorld)) discard;
  vec3 eye = parallel ? vec3(0.0, 0.0, 1.0) : normalize(-vView);
  vec3 n = normalize(vNormal);
  if (deforms) {
    // rotate the smooth normal with the deformed face
    vec3 after = cross(dx, dy), ahead = cross(dx - mx, dy - my);
    float sizes = length(after) * length(ahead);
    if (sizes > 0.0) {
      vec3 a = normalize(ahead), b = normalize(after);
      vec3 axis = cross(a, b);
      float c = dot(a, b);
      if (c > -0.99) n = normalize(n * c + cross(axis, n) + axis * dot(axis, n) / (1.0 + c));
    }
  }
  bool back = dot(n, eye) < 0.0;
  bool inside = !gl_FrontFacing;
  if (back) n = -n;
  vec3 base = toLinear(colour);
  vec3 screen;
  if (measure >= 0) {
    float span = max(range.y - range.x, 1e-37);
    float share = (vValue - range.x) / span;
    bool isKnown = vKnown > 0.5 && !isnan(vValue);
    float shown = bands > 0.0 ? (floor(clamp(share, 0.0, 0.9999) * bands) + 0.5) / bands : share;
    // range ends at the centres of the first and last texel
    vec3 c = texture(map, vec2((clamp(shown, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    if (!isKnown) c = unknown;
    if (isolines && isKnown) {
      float count = bands > 0.0 ? bands : 12.0;
      float level = share * count;
      float near = abs(fract(level - 0.5) - 0.5) / max(slope / span * count, 1e-9);
      if (share > 0.0 && share < 1.0) c = mix(c * 0.35, c, smoothstep(0.5, 1.5, near));
    }
    screen = plain ? c : toScreen(lit(toLinear(c) * 1.02, n, eye, 0.04));
  } else {
    screen = toScreen(lit(base, n, eye, 0.16));
  }
  // clipped solids have a plain interior colour
  if (inside && plane.w < 1e30) screen = mix(colour, vec3(0.5), 0.5) * 0.8;
  screen = mix(screen, glow, 0.28 * step(0.001, dot(glow, glow)));
  pixel = vec4(screen, opacity);
}
`;

export const LINE_VERTEX = /* glsl */ `
${DEFORM}
uniform float amplification;
uniform float nearer;
out vec3 vWorld;
out float vValue;
out float vKnown;
void main() {
  int v = vertexNumber();
  vec4 moves = movedBy(v);
  vec3 u = moves.xyz;
  vec3 x = position + amplification * u;
  vWorld = (modelMatrix * vec4(x, 1.0)).xyz;
  vKnown = knows == 1 ? known : float(knows);
  vValue = moves.w;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(x, 1.0));
  gl_Position.z -= nearer * gl_Position.w;
}
`;

export const LINE_FRAGMENT = /* glsl */ `
precision highp float;
${CLIP}
uniform vec3 colour;
uniform float opacity;
uniform int measure;
uniform vec2 range;
uniform vec3 unknown;
uniform sampler2D map;
in vec3 vWorld;
in float vValue;
in float vKnown;
out vec4 pixel;
void main() {
  if (cutAway(vWorld)) discard;
  vec3 c = colour;
  if (measure >= 0) {
    float share = (vValue - range.x) / max(range.y - range.x, 1e-37);
    c = vKnown > 0.5 && !isnan(vValue)
      ? texture(map, vec2((clamp(share, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb : unknown;
  }
  pixel = vec4(c, opacity);
}
`;

/** Picking: object number, corner index in the triangle, depth. */
export const PICK_FRAGMENT = /* glsl */ `
precision highp float;
precision highp int;
${CLIP}
uniform uint thing;
in vec3 vWorld;
flat in uint vVertex;
out uvec4 found;
void main() {
  if (cutAway(vWorld)) discard;
  found = uvec4(thing + 1u, vVertex, floatBitsToUint(gl_FragCoord.z), 1u);
}
`;

export const PICK_VERTEX = /* glsl */ `
${DEFORM}
uniform float amplification;
out vec3 vWorld;
#ifndef SHADOW
flat out uint vVertex;
#endif
void main() {
  int v = vertexNumber();
  vec3 x = position + amplification * movedBy(v).xyz;
  vWorld = (modelMatrix * vec4(x, 1.0)).xyz;
#ifndef SHADOW
  vVertex = uint(v);
#endif
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(x, 1.0));
}
`;

/** Measure of each vertex, written to one of several pixels: value and negative value. */
export const EXTREMES_VERTEX = /* glsl */ `
${DEFORM}
uniform float lanes;
out vec2 vBoth;
void main() {
  int v = vertexNumber();
  float x = movedBy(v).w;
  bool counts = (knows == 1 ? known : float(knows)) > 0.5 && !isnan(x);
  vBoth = vec2(x, -x);
  float lane = float(v % int(lanes));
  gl_Position = counts ? vec4((2.0 * lane + 1.0) / lanes - 1.0, 0.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
}
`;

export const EXTREMES_FRAGMENT = /* glsl */ `
precision highp float;
in vec2 vBoth;
out vec4 pixel;
void main() { pixel = vec4(vBoth, 0.0, 0.0); }
`;

export const SHADOW_FRAGMENT = /* glsl */ `
precision highp float;
${CLIP}
in vec3 vWorld;
out vec4 pixel;
void main() {
  if (cutAway(vWorld)) discard;
  pixel = vec4(1.0);
}
`;
