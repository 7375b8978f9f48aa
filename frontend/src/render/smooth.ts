/** Vertex normals that are smooth over curved faces and split at creases. */

export interface Smooth {
  /** Body vertex of each drawn corner. */
  source: Uint32Array;
  normals: Float32Array;
  /** Drawn corners of each triangle. */
  index: Uint32Array;
}

/** Split the vertices of a surface at creases above an angle, rad. */
export function smooth(positions: Float32Array, triangles: Uint32Array, crease = 0.6): Smooth {
  const nt = triangles.length / 3, nv = positions.length / 3;
  // unit normals and areas of the faces
  const faces = new Float32Array(3 * nt), areas = new Float32Array(nt);
  for (let t = 0; t < nt; t++) {
    const a = 3 * triangles[3 * t], b = 3 * triangles[3 * t + 1], c = 3 * triangles[3 * t + 2];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const wx = positions[c] - positions[a], wy = positions[c + 1] - positions[a + 1], wz = positions[c + 2] - positions[a + 2];
    const x = uy * wz - uz * wy, y = uz * wx - ux * wz, z = ux * wy - uy * wx;
    const size = Math.hypot(x, y, z);
    areas[t] = size;
    if (size > 0) faces.set([x / size, y / size, z / size], 3 * t);
  }
  // corners around each vertex
  const from = new Uint32Array(nv + 1);
  for (const v of triangles) from[v + 1]++;
  for (let v = 0; v < nv; v++) from[v + 1] += from[v];
  const corners = new Uint32Array(triangles.length), next = from.slice();
  triangles.forEach((v, corner) => (corners[next[v]++] = corner));
  // groups of faces around the vertex that form one smooth surface
  const limit = Math.cos(crease);
  const index = new Uint32Array(triangles.length);
  const source: number[] = [], sums: number[] = [];
  for (let v = 0; v < nv; v++) {
    const start = source.length;
    for (let k = from[v]; k < from[v + 1]; k++) {
      const corner = corners[k], t = Math.floor(corner / 3);
      const x = faces[3 * t], y = faces[3 * t + 1], z = faces[3 * t + 2];
      let group = -1, best = limit;
      for (let g = start; g < source.length; g++) {
        const sx = sums[3 * g], sy = sums[3 * g + 1], sz = sums[3 * g + 2];
        const near = (x * sx + y * sy + z * sz) / (Math.hypot(sx, sy, sz) || 1);
        if (near > best) {
          best = near;
          group = g;
        }
      }
      const w = areas[t];
      if (group < 0) {
        group = source.length;
        source.push(v);
        sums.push(w * x, w * y, w * z);
      } else {
        sums[3 * group] += w * x;
        sums[3 * group + 1] += w * y;
        sums[3 * group + 2] += w * z;
      }
      index[corner] = group;
    }
  }
  const normals = new Float32Array(sums.length);
  for (let g = 0; g < source.length; g++) {
    const size = Math.hypot(sums[3 * g], sums[3 * g + 1], sums[3 * g + 2]) || 1;
    for (let i = 0; i < 3; i++) normals[3 * g + i] = sums[3 * g + i] / size;
  }
  return { source: Uint32Array.from(source), normals, index };
}
