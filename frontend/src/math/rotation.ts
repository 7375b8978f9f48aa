/** Rotations as 9 matrix entries, row by row, and Euler parameters, scalar first. */

export type Matrix = Float64Array;

/** `A(e)`, whose columns are the body's axes in the world; `e` need not have unit length. */
export function matrix(e: ArrayLike<number>, at = 0, out: Matrix = new Float64Array(9)): Matrix {
  const a = e[at], b = e[at + 1], c = e[at + 2], d = e[at + 3];
  const n = a * a + b * b + c * c + d * d;
  const s = n > 0 ? 2 / n : 0;
  out[0] = 1 - s * (c * c + d * d);
  out[1] = s * (b * c - a * d);
  out[2] = s * (b * d + a * c);
  out[3] = s * (b * c + a * d);
  out[4] = 1 - s * (b * b + d * d);
  out[5] = s * (c * d - a * b);
  out[6] = s * (b * d - a * c);
  out[7] = s * (c * d + a * b);
  out[8] = 1 - s * (b * b + c * c);
  return out;
}

/** `A B`. */
export function product(A: Matrix, B: Matrix, out: Matrix = new Float64Array(9)): Matrix {
  for (let i = 0; i < 9; i += 3) {
    const a = A[i], b = A[i + 1], c = A[i + 2];
    for (let j = 0; j < 3; j++) out[i + j] = a * B[j] + b * B[3 + j] + c * B[6 + j];
  }
  return out;
}

/** `A^T B`. */
export function transposedProduct(A: Matrix, B: Matrix, out: Matrix = new Float64Array(9)): Matrix {
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 3; j++) out[3 * i + j] = A[i] * B[j] + A[3 + i] * B[3 + j] + A[6 + i] * B[6 + j];
  }
  return out;
}

/** `A x`. */
export function turn(A: Matrix, x: number, y: number, z: number, out: Float64Array | number[]): void {
  out[0] = A[0] * x + A[1] * y + A[2] * z;
  out[1] = A[3] * x + A[4] * y + A[5] * z;
  out[2] = A[6] * x + A[7] * y + A[8] * z;
}

/** Rotation vector of a matrix; its length is the angle between 0 and pi. */
export function logarithm(A: Matrix, out: Float64Array | number[] = new Float64Array(3)): Float64Array | number[] {
  const x = 0.5 * (A[7] - A[5]), y = 0.5 * (A[2] - A[6]), z = 0.5 * (A[3] - A[1]);
  const sine = Math.hypot(x, y, z);
  const cosine = 0.5 * (A[0] + A[4] + A[8] - 1);
  if (cosine < -0.999) {
    // near pi the axis follows from the symmetric part: (A + A^T) / 2 - cos I = (1 - cos) n n^T
    const diagonal = [A[0] - cosine, A[4] - cosine, A[8] - cosine];
    const k = diagonal.indexOf(Math.max(...diagonal));
    const n = [0, 1, 2].map((i) => (i === k ? diagonal[k] : 0.5 * (A[3 * i + k] + A[3 * k + i])));
    const sign = n[0] * x + n[1] * y + n[2] * z < 0 ? -1 : 1;
    const f = (sign * Math.atan2(sine, cosine)) / Math.hypot(n[0], n[1], n[2]);
    for (let i = 0; i < 3; i++) out[i] = f * n[i];
    return out;
  }
  const f = sine > 1e-8 ? Math.atan2(sine, cosine) / sine : 1;
  out[0] = f * x;
  out[1] = f * y;
  out[2] = f * z;
  return out;
}

/** The matrix of a rotation vector (Rodrigues). */
export function exponential(v: ArrayLike<number>, out: Matrix = new Float64Array(9)): Matrix {
  const angle = Math.hypot(v[0], v[1], v[2]);
  const h = 0.5 * angle;
  const s = h > 1e-8 ? Math.sin(h) / angle : 0.5;
  return matrix([Math.cos(h), s * v[0], s * v[1], s * v[2]], 0, out);
}

/** Interpolated Euler parameters along the shorter arc (slerp). */
export function between(a: ArrayLike<number>, b: ArrayLike<number>, f: number, at = 0): [number, number, number, number] {
  let dot = 0;
  for (let i = 0; i < 4; i++) dot += a[at + i] * b[at + i];
  const sign = dot < 0 ? -1 : 1;
  const angle = Math.acos(Math.min(1, Math.abs(dot)));
  const sine = Math.sin(angle);
  const u = sine > 1e-6 ? Math.sin((1 - f) * angle) / sine : 1 - f;
  const w = sign * (sine > 1e-6 ? Math.sin(f * angle) / sine : f);
  return [0, 1, 2, 3].map((i) => u * a[at + i] + w * b[at + i]) as [number, number, number, number];
}
