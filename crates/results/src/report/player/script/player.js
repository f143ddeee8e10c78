// The player: a view with its controls.

const SPEEDS = [1, 2, 5].flatMap((digit) => [-4, -3, -2, -1, 0, 1, 2, 3, 4].map((power) => Number(`${digit}e${power}`))).sort((a, b) => a - b);

/** Seconds that a run is played for, at the speed that is chosen first. */
const PLAYED = 20;

const KEYS = "Keys: space plays and pauses, left and right arrows step, Home and End go to the ends, plus and minus change the speed";

class Player {
  constructor(container, run) {
    this.run = run;
    this.number = 0;
    this.isPlaying = false;
    this.listeners = [];
    this.chosen = -1;
    const opening = Number(container.dataset.opening ?? NaN);
    this.colourings = run.is_pictures ? [] : colourings(run, opening);
    const duration = run.times[run.frames - 1] - run.times[0];
    this.speed = SPEEDS.findLastIndex((speed) => speed * PLAYED <= duration * 1.01);
    if (this.speed < 0) this.speed = 0;
    this.build(container);
    if (run.is_pictures) this.view = new PictureView(this.canvas, (aspect) => this.setAspect(aspect));
    else this.makeView();
    this.scrub.addEventListener("input", () => this.go(Number(this.scrub.value)));
    this.root.addEventListener("keydown", (event) => this.key(event));
    this.show(0);
  }

  makeView() {
    const { run } = this;
    this.view = new View(this.canvas, run);
    this.view.afterDraw = () => this.drawScaleBar();
    const isMixed = new Set(run.speciesOf.filter((_, particle) => run.kinds[particle] === 0)).size > 1;
    // Species tell the story of a mixture; layers that of a flow.
    const layers = this.colourings.findIndex((colouring) => colouring.isLayers);
    this.colour(isMixed || this.colourings.length < 2 ? 0 : Math.max(layers, 1));
    this.listen();
  }

  build(container) {
    const { run } = this;
    const isSolid = run.dimension === 3;
    const name = run.title || run.scene;
    const turns = isSolid ? ", shift with arrows turns the view" : "";
    this.canvas = make(run.is_pictures ? "img" : "canvas", { tabIndex: 0, role: "img", "aria-label": `${name}. ${KEYS}${turns}.` });
    this.scrub = make("input", { type: "range", className: "sfp-scrub", min: 0, max: run.frames - 1, step: 1, value: 0, "aria-label": "Frame" });
    this.playButton = button("▶", "Play", () => this.toggle());
    this.facts = make("div", { className: "sfp-facts" });
    this.grain = make("p", { className: "sfp-note sfp-grain", hidden: Boolean(run.is_pictures) });
    this.live = make("div", { className: "sfp-live", role: "status" });
    this.legendBox = make("div");
    this.scaleBar = make("div", { className: "sfp-scale", "aria-hidden": "true" });
    const transport = make("div", { className: "sfp-row" }, [
      this.playButton,
      button("◂", "One frame back", () => this.step(-1)),
      button("▸", "One frame on", () => this.step(1)),
      this.scrub,
    ]);
    this.message = make("p", { className: "sfp-message", hidden: true, role: "alert" });
    this.picture = make("div", { className: "sfp-picture" }, [
      make("div", { className: "sfp-view" }, [this.canvas, this.message]),
      transport,
    ]);
    this.root = make("div", { className: "sfp", role: "group", "aria-label": `Player: ${name}` }, [
      this.picture,
      make("div", { className: "sfp-side" }, [
        this.facts,
        this.buildSettings(isSolid),
        this.legendBox,
        this.scaleBar,
        this.grain,
        make("p", { className: "sfp-note", textContent: noteOf(run) }),
      ]),
      this.live,
    ]);
    container.replaceChildren(this.root);
    const box = run.is_pictures ? null : visibleBox(run);
    const [width, height] = isSolid || !box ? [1, 1] : [0, 1].map((axis) => box[1][axis] - box[0][axis]);
    this.setAspect(width / height);
  }

  /** Sets width over height of the picture, within limits. */
  setAspect(aspect) {
    this.picture.style.setProperty("--aspect", String(Math.min(Math.max(aspect || 1, 0.85), 2.2)));
  }

  buildSettings(isSolid) {
    const { run } = this;
    const speeds = SPEEDS.map((speed, place) => [String(place), `${shortNumber(speed)} ${speedUnit(run)}`]);
    const speed = select("Speed", speeds, String(this.speed), (place) => this.setSpeed(Number(place)));
    this.speedBox = speed.box;
    if (run.is_pictures) return make("div", { className: "sfp-row sfp-settings" }, [speed.element]);
    const colours = this.colourings.map((colouring, place) => [String(place), `${colouring.name}${colouring.unit ? ` (${colouring.unit})` : ""}`]);
    const colour = select("Colour", colours, "0", (place) => this.colour(Number(place), true));
    this.colourBox = colour.box;
    const parts = [speed.element, colour.element];
    if (run.has_contacts) parts.push(checkbox("Force chains", false, (isOn) => this.toggleShown("bonds", isOn)));
    if (run.doors.length) parts.push(checkbox("Walls", true, (isOn) => this.toggleShown("walls", isOn)));
    if (isSolid) {
      const views = Object.keys(VIEWS).map((name) => [name, name]);
      const view = select("View", views, "oblique", (name) => this.look(() => this.view.camera.turnTo(...VIEWS[name])));
      const axes = [["-1", "none"], ["0", "along x"], ["1", "along y"], ["2", "along z"]];
      const cut = select("Cut", axes, "-1", (axis) => this.setCut(Number(axis)));
      this.cutPlace = slider("Depth of the cut", 100, (share) => this.look(() => (this.view.cut.share = share / 100)));
      this.cutPlace.element.hidden = true;
      parts.push(view.element, cut.element, this.cutPlace.element);
    }
    const zoom = (factor) => () => this.look(() => this.view.camera.zoomBy(factor));
    parts.push(make("span", { className: "sfp-buttons" }, [
      button("−", "Zoom out", zoom(1 / 1.25)),
      button("+", "Zoom in", zoom(1.25)),
      button("⤢", "Show all", () => this.look(() => this.view.camera.fit())),
    ]));
    return make("div", { className: "sfp-row sfp-settings" }, parts);
  }

  listen() {
    const { canvas, view } = this;
    new ResizeObserver(() => view.redraw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view.redraw());
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.pause();
      this.say("The browser has taken the graphics card away from this picture.");
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.message.hidden = true;
      view.restore();
    });
    listenToPointer(canvas, view, () => view.redraw(), (place, isClicked) => this.point(place, isClicked));
    this.point(null, false);
  }

  /** Tells the numbers of the grain at a place, or of the one that was clicked; else how the picture is moved. */
  point(place, isClicked) {
    const { view } = this;
    const pointed = place ? rowAt(view, ...place) : -1;
    if (isClicked) this.chosen = pointed < 0 ? -1 : view.particles[pointed];
    const followed = this.chosen < 0 ? -1 : view.particles.indexOf(this.chosen);
    const move = view.isSolid ? "Drag to turn, with shift to move" : "Drag to move";
    let words = `${move}; after a click the wheel zooms. Point at a grain for its numbers, click to follow it. ${KEYS}.`;
    if (pointed >= 0 && !isClicked) words = factsOf(view, this.colourings, pointed);
    else if (followed >= 0) words = `${factsOf(view, this.colourings, followed)} (followed)`;
    else if (this.chosen >= 0) words = "The grain that you follow is not in this frame.";
    this.grain.textContent = words;
  }

  /** Shows a message over the picture. */
  say(text) {
    this.message.textContent = text;
    this.message.hidden = false;
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const { target, key, shiftKey } = event;
    const isSelect = target.tagName === "SELECT";
    const isSlider = target.type === "range" && target !== this.scrub;
    const isPressed = target.tagName === "BUTTON" || target.type === "checkbox";
    const turns = { ArrowLeft: [10, 0], ArrowRight: [-10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };
    if (shiftKey && this.view.isSolid && turns[key] && target === this.canvas) {
      const { camera } = this.view;
      this.look(() => camera.turnTo(camera.turn + turns[key][0], camera.tilt + turns[key][1]));
    } else if (key === " " && !isPressed && !isSelect) this.toggle();
    else if (key === "+" || key === "=") this.setSpeed(this.speed + 1);
    else if (key === "-") this.setSpeed(this.speed - 1);
    else if (isSelect || isSlider) return;
    else if (key === "ArrowLeft") this.step(-1);
    else if (key === "ArrowRight") this.step(1);
    else if (key === "Home") this.go(0);
    else if (key === "End") this.go(this.run.frames - 1);
    else return;
    event.preventDefault();
  }

  /** Shows a frame. */
  show(number) {
    const { run, view } = this;
    this.number = Math.min(Math.max(number, 0), run.frames - 1);
    const frame = run.frameList[this.number];
    view.show(frame);
    this.scrub.value = this.number;
    this.scrub.setAttribute("aria-valuetext", momentOf(run, this.number));
    if (run.is_pictures) {
      this.facts.replaceChildren(make("b", { textContent: momentOf(run, this.number) }), `picture ${this.number + 1} of ${run.frames}`);
      return;
    }
    const [released, inside, out, lost] = run.counts.subarray(4 * this.number, 4 * this.number + 4);
    const counts = [["released", released], ["inside", inside], ["out", out], ["lost", lost], ["outside of the picture", frame.leftOut]];
    const shown = counts.filter(([name, count]) => count || !["lost", "outside of the picture"].includes(name));
    if (this.chosen >= 0) this.point(null, false);
    this.facts.replaceChildren(make("b", { textContent: momentOf(run, this.number) }), ` ${shown.map(([name, count]) => `${count} ${name}`).join(" · ")}`);
  }

  /** Shows a frame because the user wants it, and tells listeners. */
  go(number) {
    const before = this.number;
    this.show(number);
    this.clock = this.run.times[this.number];
    if (this.number !== before) this.listeners.forEach((listener) => listener(this.clock));
    if (!this.isPlaying) this.announce();
  }

  step(by) {
    this.pause();
    this.go(this.number + by);
  }

  /** Tells a screen reader the state, once it has been the same for a while. */
  announce(text = this.facts.textContent) {
    clearTimeout(this.announcing);
    this.announcing = setTimeout(() => (this.live.textContent = text), 500);
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  play() {
    if (this.number === this.run.frames - 1) this.go(0);
    this.setPlaying(true);
    this.clock = this.run.times[this.number];
    let before = performance.now();
    const tick = (now) => {
      if (!this.isPlaying) return;
      this.clock += (Math.max(now - before, 0) / 1000) * SPEEDS[this.speed];
      before = now;
      const number = frameAt(this.run.times, this.clock);
      const clock = this.clock;
      if (number !== this.number) this.go(number);
      this.clock = clock;
      if (number === this.run.frames - 1) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    if (!this.isPlaying) return;
    this.setPlaying(false);
    this.announce();
  }

  setPlaying(isPlaying) {
    this.isPlaying = isPlaying;
    const label = isPlaying ? "Pause" : "Play";
    Object.assign(this.playButton, { textContent: isPlaying ? "❚❚" : "▶", title: label });
    this.playButton.setAttribute("aria-label", label);
  }

  setSpeed(place) {
    this.speed = Math.min(Math.max(place, 0), SPEEDS.length - 1);
    this.speedBox.value = this.speed;
    this.announce(`Speed ${shortNumber(SPEEDS[this.speed])} ${speedUnit(this.run)}`);
  }

  colour(place, isChosen = false) {
    this.colouring = this.colourings[place];
    this.colourBox.value = place;
    this.view.setColouring(this.colouring);
    this.updateLegend();
    if (isChosen) this.announce(`Coloured by ${this.colouring.name}`);
  }

  toggleShown(what, isOn) {
    this.look(() => (this.view.shown[what] = isOn));
    this.updateLegend();
  }

  updateLegend() {
    this.legendBox.replaceChildren(legend(this.colouring, this.run, this.view.shown));
  }

  setCut(axis) {
    const { box, element } = this.cutPlace;
    element.hidden = axis < 0;
    if (axis >= 0 && Number(box.value) === 0) box.value = 50;
    this.look(() => Object.assign(this.view.cut, { axis, share: Number(box.value) / 100 }));
  }

  look(change) {
    change();
    this.view.redraw();
  }

  /** A bar of a round length in the scale of the picture. */
  drawScaleBar() {
    const metresPerPixel = (2 * this.view.camera.halfHeight) / this.canvas.clientHeight;
    if (metresPerPixel === this.metresPerPixel) return;
    this.metresPerPixel = metresPerPixel;
    const most = 120 * metresPerPixel;
    const power = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].map((digit) => digit * power).find((metres) => metres <= most);
    const [text, unit] = length < 0.01 ? [length * 1000, "mm"] : length < 1 ? [length * 100, "cm"] : [length, "m"];
    this.scaleBar.style.setProperty("--length", `${length / metresPerPixel}px`);
    this.scaleBar.textContent = `${shortNumber(text)} ${unit}`;
  }
}

/**
 * Fills `container` with a player of the data in the element `dataId`.
 *
 * The promise resolves to `times` (s) of the frames, `setTime(seconds)`, which shows the last frame at or before a time and calls no
 * listener, `onTime(callback)`, which calls back with the time of each frame that the user or playing selects, `play()` and `pause()`.
 * If the data are damaged or cannot be drawn, `container` shows a message, `times` is empty, and the functions do nothing.
 */
async function siloflowPlayer(container, dataId) {
  try {
    container.textContent = "Unpacking the frames …";
    const run = await decodeRun(document.getElementById(dataId)?.textContent ?? "");
    if (!run.frames) throw new Error("the run has no frames");
    const player = new Player(container, run);
    return {
      times: Array.from(run.times),
      setTime: (seconds) => player.show(frameAt(run.times, seconds)),
      onTime: (callback) => player.listeners.push(callback),
      play: () => player.play(),
      pause: () => player.pause(),
    };
  } catch (error) {
    container.replaceChildren(make("p", { className: "sfp-message", role: "alert", textContent: `The frames cannot be shown: ${error.message}.` }));
    return { times: [], setTime() {}, onTime() {}, play() {}, pause() {} };
  }
}
