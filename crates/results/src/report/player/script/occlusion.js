// Leaves out grains that are behind others. In a dense bed most are, and each pixel that is not drawn saves time.
//
// The picture is divided into square cells. Grains are visited from the viewer away. A cell is closed once a grain covers it wholly,
// and a grain of which all cells are closed is left out. Cells that several grains cover together stay open, so no visible grain is lost.

/** Number of depths that are told apart. */
const DEPTHS = 4096;

/** Side of a cell over the middle radius, and its least length in pixels. */
const CELL = [0.4, 2];

/** Rows of grains from the viewer away; `toward` points to the viewer. */
function depthOrder(places, [a, b, c]) {
  const [x, y, z] = places;
  const rows = x.length;
  // A place is a number up to 65535 along each axis.
  const high = 65535 * (Math.max(a, 0) + Math.max(b, 0) + Math.max(c, 0));
  const scale = (DEPTHS - 1) / (65535 * (Math.abs(a) + Math.abs(b) + Math.abs(c)));
  const depths = new Uint16Array(rows);
  const starts = new Uint32Array(DEPTHS + 1);
  for (let row = 0; row < rows; row++) {
    depths[row] = (high - a * x[row] - b * y[row] - c * z[row]) * scale;
    starts[depths[row] + 1]++;
  }
  for (let depth = 0; depth < DEPTHS; depth++) starts[depth + 1] += starts[depth];
  const order = new Uint32Array(rows);
  for (let row = 0; row < rows; row++) order[starts[depths[row]]++] = row;
  return order;
}

/** Rows of the grains that can be seen, from the viewer away. `pixel` and the middle radius are in m, `size` in pixels; `cut` as in the vertex program. */
function visibleRows(places, radii, step, camera, pixel, size, cut, middleRadius) {
  const order = depthOrder(places, camera.toward);
  const [x, y, z] = places;
  const { right, up, centre } = camera;
  const side = Math.max((CELL[0] * middleRadius) / pixel, CELL[1]);
  const [columns, lines] = size.map((length) => Math.ceil(length / side));
  const closed = new Uint8Array(columns * lines);
  const unit = pixel * side;
  const perCell = step / unit;
  const [u0, v0] = [right, up].map((axis, number) => size[number] / side / 2 - (axis[0] * centre[0] + axis[1] * centre[1] + axis[2] * centre[2]) / unit);
  let count = 0;
  for (let place = 0; place < order.length; place++) {
    const row = order[place];
    const [a, b, c] = [x[row], y[row], z[row]];
    if ((cut[0] * a + cut[1] * b + cut[2] * c) * step > cut[3]) continue;
    // Centre and radius in cells.
    const u = u0 + (right[0] * a + right[1] * b + right[2] * c) * perCell;
    const v = v0 + (up[0] * a + up[1] * b + up[2] * c) * perCell;
    const r = radii[row] / unit;
    const [left, end] = [Math.max(Math.floor(u - r), 0), Math.min(Math.floor(u + r), columns - 1)];
    const [low, high] = [Math.max(Math.floor(v - r), 0), Math.min(Math.floor(v + r), lines - 1)];
    let isSeen = false;
    for (let j = low; j <= high; j++) {
      const far = Math.max(Math.abs(j - v), Math.abs(j + 1 - v));
      // Cells between `inside` and `-inside` around the centre are covered wholly.
      const inside = far < r ? Math.sqrt(r * r - far * far) : -1;
      for (let i = left; i <= end; i++) {
        const cell = j * columns + i;
        if (closed[cell]) continue;
        isSeen = true;
        if (Math.max(Math.abs(i - u), Math.abs(i + 1 - u)) < inside) closed[cell] = 1;
      }
    }
    if (isSeen) order[count++] = row;
  }
  return order.subarray(0, count);
}
