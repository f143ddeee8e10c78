// The picture: a frame of a run on a canvas.

/** Colour of bonds of sliding contacts. */
const SLIDING = "#ff7f0e";

class View {
  /** Shows a run; `box` is what the view shows at first, m from the corner of the grid. */
  constructor(canvas, run, box = visibleBox(run)) {
    this.canvas = canvas;
    this.run = run;
    this.isSolid = run.dimension === 3;
    this.box = box;
    this.camera = new Camera(this.box, this.isSolid);
    this.shown = { bonds: false, walls: true };
    this.cut = { axis: -1, share: 0 };
    this.colouring = null;
    /* The frame that is shown, and the particle and the radius (m) of each of its rows. */
    this.frame = null;
    this.particles = null;
    this.radii = null;
    this.middleRadius = middle(run.radii.filter((_, particle) => run.kinds[particle] === 0)) || middle(run.radii);
    this.afterDraw = () => {};
    this.makeRenderer();
  }

  makeRenderer() {
    try {
      this.renderer = new Renderer(this.canvas, this.run);
    } catch (error) {
      if (this.isSolid) throw error;
      // A canvas that has given one kind of context gives no other.
      this.renderer = new FlatRenderer(this.canvas, this.run);
    }
    this.bondsOf = this.wallsOf = null;
  }

  /** Begins again after the graphics card was lost. */
  restore() {
    this.makeRenderer();
    this.setColouring(this.colouring);
  }

  setColouring(colouring) {
    this.colouring = colouring;
    this.renderer.setPalette(paletteOf(colouring, this.run));
    if (this.frame) this.show(this.frame);
  }

  show(frame) {
    const { run } = this;
    this.frame = frame;
    this.particles = expand(frame.runs, frame.rows, run.particles);
    this.radii = this.radiiOf(frame, this.particles);
    this.renderer.setGrains(frame.places, this.radii, colourRows(this.colouring, run, frame, this.particles));
    this.redraw();
  }

  /** The radius of each row, m. */
  radiiOf(frame, particles) {
    const { run } = this;
    const changing = run.changes_radius && colourings(run).find((colouring) => colouring.key === "radius" && colouring.place >= 0);
    if (!changing) return Float32Array.from(particles, (particle) => run.radii[particle]);
    const { low, high, place } = changing;
    return Float32Array.from(frame.levels[place], (level) => low + (level / run.top) * (high - low));
  }

  /** Draws before the next picture of the screen; a still view of solid space is then drawn again, more finely. */
  redraw() {
    clearTimeout(this.fine);
    this.isFine = false;
    this.request ??= requestAnimationFrame(() => {
      this.request = null;
      this.drawNow();
      if (this.isSolid) this.fine = setTimeout(() => this.drawFinely(), 300);
    });
  }

  drawFinely() {
    this.isFine = true;
    this.drawNow();
  }

  drawNow() {
    const { canvas, run, frame } = this;
    if (!frame || !canvas.clientWidth) return;
    const density = Math.min(Math.max(devicePixelRatio, this.isFine ? 2 : 1), 3);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((length) => Math.round(length * density));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    this.camera.aspect = width / height;
    if (this.shown.bonds && this.bondsOf !== frame) {
      this.renderer.setBonds(decodeLines(frame, run));
      this.bondsOf = frame;
    }
    const walls = frame.walls.join();
    if (this.wallsOf !== walls) {
      this.renderer.setWalls(wallArrays(frame, run));
      this.wallsOf = walls;
    }
    this.renderer.draw(this.camera, this.look(density));
    this.afterDraw();
  }

  look(density) {
    const { run, shown, isSolid, box } = this;
    const style = getComputedStyle(this.canvas);
    const ink = [...cssColour(style.color), 1];
    const colours = (isSolid ? run.surface_colours : run.wall_colours).map((text) => [...fromHex(text.slice(1)).map((byte) => byte / 255), 1]);
    const withAlpha = (alpha) => colours.map(([r, g, b]) => [r, g, b, alpha]);
    const sliding = [...fromHex(SLIDING.slice(1)).map((byte) => byte / 255), 1];
    // Points of walls are rounded, so the box in which half-spaces are drawn is a little larger.
    const around = box.map((corner, isHigh) => corner.map((place) => place + (isHigh ? 2 : -2) * run.step));
    const metres = (isSolid ? 0.9 : 0.7) * this.middleRadius;
    return {
      density,
      middleRadius: this.middleRadius,
      paper: cssColour(style.backgroundColor),
      shrink: isSolid && shown.bonds ? 0.3 : 1,
      cut: this.cutPlane(),
      bonds: shown.bonds && { metres, pixels: 0.8, casing: isSolid ? 0 : 0.6, colours: [ink, sliding], box },
      walls: shown.walls && { metres: 0, pixels: isSolid ? 1.4 : 2.5, casing: 0, colours: isSolid ? withAlpha(0.7) : colours, box: around },
      faces: withAlpha(0.09),
    };
  }

  /** The plane beyond which grains are not drawn: it cuts away the side towards the viewer. */
  cutPlane() {
    const { axis, share } = this.cut;
    const plane = [0, 0, 0, Infinity];
    if (axis < 0 || share === 0) return [0, 0, 0, 1];
    const sign = this.camera.toward[axis] < -1e-9 ? -1 : 1;
    const [low, high] = [this.box[0][axis], this.box[1][axis]];
    plane[axis] = sign;
    plane[3] = sign > 0 ? high - share * (high - low) : -(low + share * (high - low));
    return plane;
  }
}

/** The scene and the grains around it, m from the corner of the grid; grains far outside are not looked for. */
/** The box of the grains of all frames, m from the corner of the grid; null without grains. */
function boxOfGrains(run) {
  const low = new Array(run.dimension).fill(Infinity);
  const high = new Array(run.dimension).fill(-Infinity);
  for (const frame of run.frameList) {
    const particles = expand(frame.runs, frame.rows, run.particles);
    for (let row = 0; row < frame.rows; row++) {
      if (run.kinds[particles[row]] !== 0) continue;
      for (let axis = 0; axis < run.dimension; axis++) {
        const place = frame.places[axis][row];
        if (place < low[axis]) low[axis] = place;
        if (place > high[axis]) high[axis] = place;
      }
    }
  }
  if (!(low[0] <= high[0])) return null;
  const margin = 0.06 * run.step * Math.max(...low.map((_, axis) => high[axis] - low[axis])) + 2 * run.radii.reduce((a, b) => Math.max(a, b), 0);
  return [low.map((place) => place * run.step - margin), high.map((place) => place * run.step + margin)];
}

/** The box that the view shows at first: the grains of the whole run, as far as they are near the walls. */
function visibleBox(run) {
  const [low, high] = sceneBox(run);
  const grains = boxOfGrains(run);
  if (!grains) return [low, high];
  for (let axis = 0; axis < run.dimension; axis++) {
    low[axis] = Math.max(low[axis], grains[0][axis]);
    high[axis] = Math.min(high[axis], grains[1][axis]);
  }
  return [low, high];
}

/** The box of the scene with a margin. */
function sceneBox(run) {
  const size = Math.max(...[0, 1, 2].map((axis) => run.domain[1][axis] - run.domain[0][axis]));
  const margin = Number.isFinite(size) ? 0.12 * size : 0;
  const low = [0, 1, 2].map((axis) => (size > 0 ? Math.max(run.low[axis], run.domain[0][axis] - margin) : run.low[axis]) - run.low[axis]);
  const high = [0, 1, 2].map((axis) => (size > 0 ? Math.min(run.high[axis], run.domain[1][axis] + margin) : run.high[axis]) - run.low[axis]);
  return [low, high];
}

/** The middle one of some numbers in their order. */
function middle(numbers) {
  return Float32Array.from(numbers).sort()[numbers.length >> 1] ?? 0;
}

/** Red, green and blue from 0 to 1 of a colour in any notation of CSS. */
function cssColour(text) {
  cssColour.known ??= new Map();
  if (!cssColour.known.has(text)) {
    const context = make("canvas", { width: 1, height: 1 }).getContext("2d");
    context.fillStyle = text;
    context.fillRect(0, 0, 1, 1);
    cssColour.known.set(text, Array.from(context.getImageData(0, 0, 1, 1).data.slice(0, 3), (byte) => byte / 255));
  }
  return cssColour.known.get(text);
}
