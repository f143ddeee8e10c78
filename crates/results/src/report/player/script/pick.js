// The grain under the pointer, and its numbers in words.

/** The row of the grain that is drawn at a place, in parts of the half height from the middle of the picture; -1 without one. */
function rowAt(view, x, y) {
  const { camera, frame, radii, run } = view;
  const plane = view.cutPlane();
  const along = (direction, place) => direction[0] * place[0] + direction[1] * place[1] + direction[2] * place[2];
  const [across, up, toward] = [camera.right, camera.up, camera.toward].map((direction) => along(direction, camera.centre));
  const place = [0, 0, 0];
  let [found, nearest] = [-1, -Infinity];
  for (let row = 0; row < frame.rows; row++) {
    for (let axis = 0; axis < run.dimension; axis++) place[axis] = frame.places[axis][row] * run.step;
    const right = along(camera.right, place) - across - x * camera.halfHeight;
    const high = along(camera.up, place) - up - y * camera.halfHeight;
    const within = radii[row] ** 2 - right * right - high * high;
    if (within < 0 || along(plane, place) > plane[3]) continue;
    const depth = along(camera.toward, place) - toward + Math.sqrt(within);
    if (depth > nearest) [found, nearest] = [row, depth];
  }
  return found;
}

/** The numbers of a row in words: `grain 12: x 0.31 m, y 0.52 m, radius 5 mm, speed 0.2 m/s`. */
function factsOf(view, colourings, row) {
  const { frame, particles, radii, run } = view;
  const particle = particles[row];
  const isGrain = run.kinds[particle] === 0;
  const name = ["grain", "wall grain", "door grain"][Math.min(run.kinds[particle], 2)];
  const places = frame.places.slice(0, run.dimension).map((axis, number) => `${"xyz"[number]} ${shortNumber(run.low[number] + axis[row] * run.step)} m`);
  const quantities = colourings.filter((colouring) => isGrain && colouring.key && colouring.key !== "radius");
  const numbers = quantities.flatMap((colouring) => {
    const level = colouring.place >= 0 ? frame.levels[colouring.place][row] : colouring.levels[particle];
    if (level === NO_NUMBER) return [];
    const share = colouring.isRoot ? (level / run.top) ** 2 : level / run.top;
    const value = colouring.low + share * (colouring.high - colouring.low);
    return `${colouring.name} ${shortNumber(value, 2)}${colouring.unit ? ` ${colouring.unit}` : ""}`;
  });
  return `${name} ${Math.abs(run.ids[particle])}: ${[...places, `radius ${shortNumber(radii[row] * 1000)} mm`, ...numbers].join(", ")}`;
}
