// The quantities that colour grains, and their colours.

/** Places of the colours in a palette: levels or species, no number, wall grain, door grain. */
const NO_NUMBER = 255;
const WALL_GRAIN = 256;
const PALETTE_SIZE = 258;

function fromHex(text) {
  return [0, 2, 4].map((at) => parseInt(text.slice(at, at + 2), 16));
}

/** Bands of grains that lay on each other. */
const LAYERS = 10;

/** Grains by the height at which they lay when the door opened, or else when most were inside; null unless grains flow out. */
function layers(run, opening) {
  const { frames, counts, frameList, dimension, top } = run;
  const inside = (number) => counts[4 * number + 1];
  const out = (number) => counts[4 * number + 2];
  if (!(out(frames - 1) > 0)) return null;
  let at = Number.isFinite(opening) ? frameAt(run.times, opening) : 0;
  if (!Number.isFinite(opening)) for (let number = 0; number < frames; number++) if (inside(number) >= inside(at)) at = number;
  const frame = frameList[at];
  const particles = expand(frame.runs, frame.rows, run.particles);
  const heights = frame.places[dimension - 1];
  // All spheres of a grain are in the layer of their mean height.
  const grains = new Map();
  particles.forEach((particle, row) => {
    if (run.kinds[particle] !== 0) return;
    const grain = grains.get(run.ids[particle]) ?? { spheres: [], sum: 0 };
    grain.spheres.push(particle);
    grain.sum += heights[row];
    grains.set(run.ids[particle], grain);
  });
  const height = ({ spheres, sum }) => sum / spheres.length;
  const sorted = [...grains.values()].sort((a, b) => height(a) - height(b));
  if (sorted.length < 2 * LAYERS) return null;
  const levels = new Uint8Array(run.particles).fill(NO_NUMBER);
  sorted.forEach(({ spheres }, rank) => {
    const level = Math.round((Math.floor((LAYERS * rank) / sorted.length) * top) / (LAYERS - 1));
    for (const particle of spheres) levels[particle] = level;
  });
  return { name: `layer at ${momentOf(run, at)}`, unit: "", isLayers: true, low: 1, high: LAYERS, palette: run.palettes[0], levels, place: -1 };
}

/** Quantities by which grains can be coloured; the first is the species. */
function colourings(run, opening) {
  const species = { name: "species", unit: "", isSpecies: true };
  let changing = 0;
  const quantities = run.quantities.map((quantity) => ({
    key: quantity.name,
    name: quantity.label,
    palette: run.palettes[quantity.palette],
    unit: quantity.unit,
    low: quantity.low,
    high: quantity.high,
    isBelow: quantity.smallest < quantity.low,
    isAbove: quantity.largest > quantity.high,
    largest: quantity.largest,
    isRoot: quantity.is_root,
    levels: quantity.is_kept ? quantity.levels : null,
    place: quantity.is_kept ? -1 : changing++,
  }));
  const last = run.times[run.frames - 1] ?? 0;
  const ages = Array.from(run.first).filter((_, particle) => run.kinds[particle] === 0);
  const oldest = ages.reduce((age, first) => Math.max(age, last - first), 0);
  const age = oldest > 0 ? [{ name: "age", unit: "s", low: 0, high: oldest, isAge: true, palette: run.palettes[0] }] : [];
  const rank = (colouring) => ["speed", "pressure", "age", "coordination"].indexOf(colouring.key ?? colouring.name) + 1 || 9;
  const layered = layers(run, opening);
  return [species, ...[...quantities, ...age].sort((a, b) => rank(a) - rank(b)), ...(layered ? [layered] : [])];
}

/** The place in the palette of each row of a frame. */
function colourRows(colouring, run, frame, particles) {
  const places = new Uint16Array(frame.rows);
  const levelsPerSecond = colouring.isAge ? run.top / colouring.high : 0;
  const column = colouring.place >= 0 ? frame.levels[colouring.place] : null;
  for (let row = 0; row < places.length; row++) {
    const particle = particles[row];
    const kind = run.kinds[particle];
    if (kind > 0) places[row] = WALL_GRAIN + Math.min(kind, 2) - 1;
    else if (colouring.isSpecies) places[row] = Math.min(run.speciesOf[particle], NO_NUMBER);
    else if (colouring.isAge) places[row] = Math.min(Math.max((frame.time - run.first[particle]) * levelsPerSecond, 0), run.top);
    else places[row] = column ? column[row] : colouring.levels[particle];
  }
  return places;
}

/** The palette of a colouring: four bytes for each place. */
function paletteOf(colouring, run) {
  const palette = new Uint8Array(4 * PALETTE_SIZE).fill(255);
  const set = (place, text) => palette.set(fromHex(text), 4 * place);
  for (let place = 0; place < NO_NUMBER; place++) {
    const species = run.species[place];
    set(place, colouring.isSpecies ? (species ? species[1].slice(1) : "808080") : colouring.palette.slice(6 * place, 6 * place + 6));
  }
  set(NO_NUMBER, "808080");
  run.wall_colours.forEach((text, kind) => set(WALL_GRAIN + kind, text.slice(1)));
  return palette;
}

/** About `count` round numbers between two others. */
function ticks(low, high, count) {
  const span = high - low;
  if (!(span > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(span / count));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((length) => span / length <= count);
  const list = [];
  for (let number = Math.ceil(low / step - 1e-9); number * step <= high + 1e-9 * span; number++) list.push(number * step);
  return list;
}

/** A number with few digits, `digits` of them significant. */
function shortNumber(number, digits = 3) {
  if (number === 0) return "0";
  const size = Math.abs(number);
  if (size >= 1e5 || size < 1e-3) {
    const [mantissa, exponent] = number.toExponential(digits - 1).split("e");
    return `${Number(mantissa)}×10${Number(exponent).toString().replace(/[-\d]/g, (sign) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign] ?? "⁻")}`;
  }
  return String(Number(number.toPrecision(digits))).replace("-", "−");
}
