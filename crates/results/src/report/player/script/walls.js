// Walls of a frame as triangles, edges and lines.

/** Cosine of the smallest angle between two triangles whose common side is drawn. */
const SHARP = Math.cos((25 * Math.PI) / 180);

/** Returns the lines of a shape: its own, and the sides of triangles where the surface ends or has a sharp bend. */
function edgesOf(shape) {
  if (shape.edges) return shape.edges;
  const edges = Array.from(shape.lines);
  const sides = new Map();
  const point = (number) => shape.points.subarray(3 * number, 3 * number + 3);
  // Triangles that meet often have points of their own.
  const nameOf = (number) => point(number).join();
  for (let i = 0; i < shape.triangles.length; i += 3) {
    const corners = shape.triangles.subarray(i, i + 3);
    const [a, b, c] = Array.from(corners, point);
    const [u, v] = [b, c].map((end) => [0, 1, 2].map((axis) => end[axis] - a[axis]));
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const size = Math.hypot(...normal) || 1;
    const unit = normal.map((share) => share / size);
    for (const [from, to] of [[0, 1], [1, 2], [2, 0]]) {
      const ends = [nameOf(corners[from]), nameOf(corners[to])].sort().join(" ");
      const side = sides.get(ends) ?? { from: corners[from], to: corners[to], normals: [] };
      side.normals.push(unit);
      sides.set(ends, side);
    }
  }
  for (const { from, to, normals } of sides.values()) {
    const [a, b] = normals;
    const isFlat = normals.length === 2 && Math.abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) > SHARP;
    if (!isFlat) edges.push(from, to);
  }
  shape.edges = Uint32Array.from(edges);
  return shape.edges;
}

/** Whether a wall is a half-space: other walls are inside of the scene's box at the start. */
function isEndless(wall, run) {
  const points = run.shapes[run.walls[wall]]?.points ?? [];
  const isOut = (number, axis) =>
    Math.max(run.domain[0][axis] - run.low[axis] - number * run.step, number * run.step - run.domain[1][axis] + run.low[axis]) > 2 * run.step;
  return Array.from(points).some((number, place) => isOut(number, place % 3));
}

/** The walls of a frame: corners of triangles with the kind (1 for a door, and 2 more for a half-space), and lines with both ends, width 1 and kind. */
function wallArrays(frame, run) {
  const [faces, lines] = [[], []];
  run.endless ??= run.doors.map((_, wall) => isEndless(wall, run));
  frame.walls.forEach((number, wall) => {
    const shape = run.shapes[number];
    if (!shape?.points.length) return;
    const kind = (run.doors[wall] ? 1 : 0) + (run.endless[wall] ? 2 : 0);
    const at = (point) => [0, 1, 2].map((axis) => shape.points[3 * point + axis] * run.step);
    for (const point of shape.triangles) faces.push(...at(point), kind);
    const edges = edgesOf(shape);
    for (let i = 0; i < edges.length; i += 2) lines.push(...at(edges[i]), ...at(edges[i + 1]), 1, kind);
  });
  return { faces: new Float32Array(faces), lines: new Float32Array(lines) };
}
