// The silo in motion: the view of the player, with a new run of one frame for each picture.

class LiveView {
  constructor(canvas, message) {
    this.canvas = canvas;
    this.message = message;
    this.wanted = "speed";
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => this.view?.restore());
    new ResizeObserver(() => this.view?.redraw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.view?.redraw());
  }

  /** Shows what the program has packed. Returns the run of one frame. */
  show(bytes) {
    const all = new Bytes(bytes);
    const length = new DataView(all.take(4).slice().buffer).getUint32(0, true);
    const run = decodeParts(new Bytes(all.take(length)), new Bytes(all.take(bytes.length - 4 - length)));
    const grid = JSON.stringify([run.scene, run.dimension, run.domain, run.low, run.step]);
    if (!this.view || this.grid !== grid) this.begin(run);
    else this.adopt(run);
    this.grid = grid;
    this.colourings = colourings(run, NaN).filter((colouring) => !colouring.isLayers);
    this.colouring = this.colourings.find((colouring) => (colouring.key ?? colouring.name) === this.wanted) ?? this.colourings[0];
    this.view.setColouring(this.colouring);
    this.view.show(run.frameList[0]);
    return run;
  }

  begin(run) {
    const shown = this.view?.shown;
    // A canvas keeps its kind of context, so each view gets a canvas of its own.
    if (this.view) {
      const canvas = this.canvas.cloneNode();
      this.canvas.replaceWith(canvas);
      this.canvas = canvas;
      new ResizeObserver(() => this.view?.redraw()).observe(canvas);
    }
    try {
      this.view = new View(this.canvas, run, sceneBox(run));
      this.message.hidden = true;
    } catch (error) {
      this.view = null;
      this.message.textContent = `The grains cannot be drawn: ${error.message}.`;
      this.message.hidden = false;
      throw error;
    }
    if (shown) this.view.shown = shown;
    listenToPointer(this.canvas, this.view, () => this.view.redraw());
  }

  /** The next run in the place of the one before. */
  adopt(run) {
    const { view } = this;
    run.lastShape = null;
    Object.assign(view, { run, frame: null, bondsOf: null, wallsOf: null });
    view.renderer.run = run;
    view.middleRadius = middle(run.radii.filter((_, particle) => run.kinds[particle] === 0)) || middle(run.radii);
  }
}
