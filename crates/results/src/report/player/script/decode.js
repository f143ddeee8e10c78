// Unpacks the data of a run (crates/results/src/report/player/packing.rs describes its bytes).

/** Reads bytes from the front; throws past their end. */
class Bytes {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  take(count) {
    const end = this.at + count;
    if (!(end <= this.bytes.length)) throw new Error("the data end too early");
    const part = this.bytes.subarray(this.at, end);
    this.at = end;
    return part;
  }

  /** An array of numbers of one type, with memory of its own. */
  column(Type, count) {
    const part = this.take(count * Type.BYTES_PER_ELEMENT);
    return new Type(part.slice().buffer);
  }

  number() {
    let value = 0;
    for (let factor = 1; ; factor *= 128) {
      const byte = this.take(1)[0];
      value += (byte & 127) * factor;
      if (byte < 128) return value;
      if (factor > 2 ** 28) throw new Error("a number is too long");
    }
  }

  signed() {
    const number = this.number();
    return number % 2 ? -(number + 1) / 2 : number / 2;
  }

  /** A number of elements that take at least a byte each. */
  within(count) {
    if (count > this.bytes.length - this.at) throw new Error("the data end too early");
    return count;
  }

  /** A part whose length stands before it. */
  part() {
    return this.take(this.number());
  }
}

async function inflate(text) {
  const letters = atob(text.trim());
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Bytes(new Uint8Array(await new Response(stream).arrayBuffer()));
}

/** Unpacks the text of a data element into a run. */
async function decodeRun(text) {
  const [first, second] = text.trim().split(" ");
  if (!second) throw new Error("there are no data");
  return decodeParts(...(await Promise.all([inflate(first), inflate(second)])));
}

/** Unpacks the two parts of a run. */
function decodeParts(facts, frames) {
  const length = new DataView(facts.take(4).slice().buffer).getUint32(0, true);
  const run = JSON.parse(new TextDecoder().decode(facts.take(length)));
  if (run.is_pictures) return decodePictures(run, facts, frames);
  const count = run.particles;
  run.times = facts.column(Float64Array, run.frames);
  run.counts = facts.column(Float64Array, 4 * run.frames);
  const lengths = facts.column(Uint32Array, run.frames);
  run.ids = facts.column(Int32Array, count);
  run.radii = facts.column(Float32Array, count);
  run.first = facts.column(Float32Array, count);
  run.kinds = facts.column(Uint8Array, count);
  run.speciesOf = facts.column(Uint8Array, count);
  for (const quantity of run.quantities) {
    if (quantity.is_kept) quantity.levels = facts.column(Uint8Array, count);
  }
  run.shapes = [];
  run.walls = decodeWalls(facts, run, []);
  run.frameList = decodeFrames(frames, lengths, run);
  return run;
}

/** Adds the geometries that a part defines to `run.shapes`, and returns the geometry of each wall, `walls` with changes. */
function decodeWalls(bytes, run, walls) {
  const now = walls.slice();
  for (let left = bytes.number(); left > 0; left--) {
    const wall = bytes.number();
    const kind = bytes.number();
    if (kind === 0) {
      now[wall] = bytes.number();
      continue;
    }
    const count = bytes.number();
    const points = new Int32Array(bytes.within(3 * count));
    const before = run.lastShape?.get(wall)?.points;
    for (let i = 0; i < points.length; i++) points[i] = bytes.signed() + (before?.length === points.length ? before[i] : 0);
    const places = (ends) => {
      const list = new Uint32Array(bytes.within(ends * bytes.number()));
      for (let i = 0; i < list.length; i++) {
        list[i] = bytes.number();
        if (list[i] >= count) throw new Error("a wall has too few points");
      }
      return list;
    };
    const start = run.shapes[run.walls?.[wall]] ?? { lines: [], triangles: [] };
    const shape = kind === 2
      ? { wall, points, lines: places(2), triangles: places(3) }
      : { wall, points, lines: count ? start.lines : [], triangles: count ? start.triangles : [] };
    run.lastShape ??= new Map();
    run.lastShape.set(wall, shape);
    now[wall] = run.shapes.push(shape) - 1;
  }
  return now;
}

/** Unpacks all frames. Numbers of grains become absolute; contacts stay packed until they are drawn. */
function decodeFrames(all, lengths, run) {
  const count = run.particles;
  const axes = run.dimension;
  const changing = run.quantities.filter((quantity) => !quantity.is_kept);
  let places = new Uint16Array(axes * count);
  let levels = new Uint8Array(changing.length * count);
  const list = [];
  for (let number = 0; number < run.frames; number++) {
    const bytes = new Bytes(all.take(lengths[number]));
    const rows = bytes.number();
    const runs = new Uint32Array(bytes.within(2 * bytes.number()));
    for (let i = 0; i < runs.length; i++) runs[i] = bytes.number();
    const particles = expand(runs, rows, count);
    const frame = { number, time: run.times[number], rows, runs, leftOut: bytes.number(), places: [], levels: [] };
    const nextPlaces = new Uint16Array(axes * count);
    for (let axis = 0; axis < axes; axis++) {
      const low = bytes.take(rows);
      const high = bytes.take(rows);
      const column = new Uint16Array(rows);
      for (let row = 0; row < rows; row++) {
        const at = axis * count + particles[row];
        nextPlaces[at] = column[row] = places[at] + low[row] + 256 * high[row];
      }
      frame.places.push(column);
    }
    const nextLevels = new Uint8Array(changing.length * count);
    for (let quantity = 0; quantity < changing.length; quantity++) {
      const column = bytes.take(rows);
      for (let row = 0; row < rows; row++) {
        const at = quantity * count + particles[row];
        nextLevels[at] = column[row] = levels[at] + column[row];
      }
      frame.levels.push(column);
    }
    [places, levels] = [nextPlaces, nextLevels];
    const contacts = () => ({ count: bytes.number(), rows: bytes.part(), partners: bytes.part(), forces: null });
    frame.contacts = [contacts(), null];
    frame.contacts[0].forces = bytes.take(frame.contacts[0].count);
    frame.contacts[1] = contacts();
    frame.contacts[1].forces = bytes.take(frame.contacts[1].count);
    run.hasSliding ||= frame.contacts.some((contacts) => contacts.forces.some((force) => force & 1));
    frame.walls = decodeWalls(bytes, run, run.walls);
    list.push(frame);
  }
  return list;
}

/** The particles of a frame's rows, from runs of absent and present ones. */
function expand(runs, rows, count) {
  const particles = new Uint32Array(Math.min(rows, count));
  let row = 0;
  let particle = 0;
  for (let i = 0; i < runs.length; i += 2) {
    particle += runs[i];
    if (particle + runs[i + 1] > count || row + runs[i + 1] > rows) break;
    for (let taken = runs[i + 1]; taken > 0; taken--) particles[row++] = particle++;
  }
  if (row !== rows) throw new Error("a frame has other grains than the run");
  return particles;
}

/**
 * The contacts of a frame as lines: for each eight numbers, both ends (m, from the corner of the grid), force from 0 to 1, sliding.
 * A contact across a periodic side is two lines, from each of both grains half the way to the other's image.
 */
function decodeLines(frame, run) {
  const { dimension: axes, step, top_force: top } = run;
  const periods = run.periodic.map((side) => (side ? side[1] - side[0] : 0));
  const [between, withWalls] = frame.contacts;
  const lines = new Float32Array(8 * (2 * between.count + withWalls.count));
  const [from, to, shift] = [new Float64Array(3), new Float64Array(3), new Float64Array(3)];
  let end = 0;
  const add = (a, b, share, force) => {
    for (let axis = 0; axis < 3; axis++) {
      lines[end + axis] = a[axis];
      lines[end + 3 + axis] = a[axis] + share * (b[axis] - a[axis]);
    }
    lines[end + 6] = (force >> 1) / top;
    lines[end + 7] = force & 1;
    end += 8;
  };
  const each = (contacts, other) => {
    const [rows, partners] = [new Bytes(contacts.rows), new Bytes(contacts.partners)];
    for (let i = 0, row = 0; i < contacts.count; i++) {
      row += rows.number();
      if (row >= frame.rows) throw new Error("a contact has no grain");
      for (let axis = 0; axis < axes; axis++) from[axis] = frame.places[axis][row] * step;
      other(row, partners, contacts.forces[i]);
    }
  };
  each(between, (row, partners, force) => {
    const partner = row + partners.number();
    if (partner >= frame.rows) throw new Error("a contact has no partner");
    let isAcross = false;
    for (let axis = 0; axis < axes; axis++) {
      to[axis] = frame.places[axis][partner] * step;
      shift[axis] = periods[axis] > 0 ? periods[axis] * Math.round((to[axis] - from[axis]) / periods[axis]) : 0;
      isAcross ||= shift[axis] !== 0;
    }
    if (!isAcross) return add(from, to, 1, force);
    add(from, to.map((coordinate, axis) => coordinate - shift[axis]), 0.5, force);
    add(to, from.map((coordinate, axis) => coordinate + shift[axis]), 0.5, force);
  });
  each(withWalls, (row, partners, force) => {
    for (let axis = 0; axis < axes; axis++) to[axis] = from[axis] + partners.signed() * step;
    add(from, to, 1, force);
  });
  return lines.subarray(0, end);
}
