// The page: one scene in the editor, and one run.

const at = (id) => document.getElementById(id);
const KEPT = "siloflow.scene";
const SPEEDS = [["Infinity", "free"], ...[0.1, 0.25, 0.5, 1, 2, 5, 10].map((speed) => [String(speed), `${speed} × real`])];
/** Milliseconds without an edit before a scene is examined, and most milliseconds for that. */
const PAUSE = 350;
const PATIENCE = 20_000;
/** Files to download singly, if a run has written them. */
const SINGLE = ["series.csv", "state.csv", "summary.json", "frames.bin"];

const page = {
  scene: { name: "silo1", from: "silo1", files: [] },
  examined: null,
  /** none, ready, running, paused, over */
  state: "none",
  isExamining: false,
  examinations: 0,
};
const program = unpackProgram();
program.catch((error) => crashed(`The program could not be unpacked: ${error.message}`));
const editing = new Engine(program);
let running = null;
const live = new LiveView(at("canvas"), at("message"));
let curves = null;

const editor = new Editor(() => edited());

function tell(words) {
  at("told").textContent = words;
}

function crashed(words) {
  at("crash").textContent = words;
  at("crash").hidden = false;
}

/** Keeps the text, so that it is there after a reload and after a crash. */
function keep() {
  try {
    const { name, from } = page.scene;
    localStorage.setItem(KEPT, JSON.stringify({ name, from, text: editor.value }));
  } catch {
    tell("This browser keeps no text: copy it before you leave.");
  }
}

function kept() {
  try {
    const scene = JSON.parse(localStorage.getItem(KEPT));
    return typeof scene?.text === "string" ? { ...scene, name: safeName(scene.name) } : null;
  } catch {
    return null;
  }
}

const sceneNow = () => ({ name: page.scene.name, content: editor.value, files: page.scene.files });

function edited() {
  keep();
  clearTimeout(page.timer);
  page.timer = setTimeout(preview, PAUSE);
}

/** Examines the scene, and shows its first moment, unless a run goes on or has results. */
async function preview() {
  page.timer = 0;
  const isIdle = page.state === "none" || page.state === "ready";
  if ((await examine()) && isIdle && page.state !== "running") await begin();
}

/** Lets the program examine the scene, and shows what it says. Returns whether the scene can be run. */
async function examine() {
  clearTimeout(page.timer);
  page.timer = 0;
  const number = ++page.examinations;
  const box = at("verdict");
  if (!box.firstChild) box.replaceChildren(make("div", { className: "plain", textContent: "The scene is being examined …" }));
  try {
    const found = await editing.ask("examine", sceneNow(), PATIENCE);
    if (number !== page.examinations) return false;
    page.examined = found;
    showExamination(found);
    return true;
  } catch (trouble) {
    if (number !== page.examinations) return false;
    page.examined = null;
    showTrouble(trouble);
    return false;
  } finally {
    if (number === page.examinations) updateControls();
  }
}

function showExamination(found) {
  editor.mark(null);
  const note = (className, text, help) => make("div", { className }, [text, ...(help ? [make("span", { className: "help", textContent: help })] : [])]);
  const warnings = found.warnings.map(({ message, help }) => note("warning", message, help));
  at("verdict").replaceChildren(note("good", `The scene is right${warnings.length ? `; ${warnings.length} warning${warnings.length > 1 ? "s" : ""}` : ""}.`), ...warnings);
  at("estimates").hidden = false;
  at("estimates").querySelector("pre").textContent = found.estimates;
  showParameters(found.parameters);
}

/** Shows a trouble at its place. A trouble in another file names the file. */
function showTrouble(trouble) {
  const isHere = trouble.line && (!trouble.file || trouble.file.endsWith(".ron"));
  editor.mark(isHere ? trouble : null);
  const place = trouble.line ? `${isHere ? "Line" : `${trouble.file}, line`} ${trouble.line}, column ${trouble.column}: ` : "";
  const parts = [make("b", { textContent: place }), trouble.message];
  if (trouble.help) parts.push(make("span", { className: "help", textContent: trouble.help }));
  if (isHere) parts.push(make("button", { type: "button", id: "go", textContent: "Go there", onclick: () => editor.go() }));
  at("verdict").replaceChildren(make("div", { className: "bad" }, parts));
  at("estimates").hidden = true;
}

/** A slider for each parameter that is a number, from half to twice of it. */
function showParameters(parameters) {
  const box = at("parameters");
  const names = parameters.map(({ name }) => name).join();
  if (box.dataset.names === names) {
    // A slider that is moved keeps its range.
    for (const { name, value } of parameters) {
      const input = [...box.querySelectorAll("input")].find((slider) => slider.dataset.name === name);
      if (input && input !== document.activeElement) setSlider(input, value);
    }
    return;
  }
  box.dataset.names = names;
  box.replaceChildren(...parameters.map(({ name, value }) => {
    const input = make("input", { type: "range", "data-name": name });
    input.addEventListener("input", () => slide(name, input));
    const row = make("label", {}, [make("span", { textContent: name, title: name }), input, make("output")]);
    setSlider(input, value);
    return row;
  }));
}

function setSlider(input, value) {
  const size = Math.abs(value) || 1;
  const isCount = Number.isInteger(value) && size >= 5;
  const step = isCount ? 10 ** Math.max(Math.floor(Math.log10(size)) - 1, 0) : 10 ** (Math.floor(Math.log10(size)) - 2);
  const ends = [value / 2, 2 * value || 1].sort((a, b) => a - b);
  Object.assign(input, { min: Math.floor(ends[0] / step) * step, max: Math.ceil(ends[1] / step) * step, step: "any" });
  input.dataset.step = step;
  input.value = value;
  const output = input.parentElement?.querySelector("output") ?? input.nextElementSibling;
  if (output) output.textContent = String(value);
}

/** Writes the number of a slider into the text, by the program. */
async function slide(name, input) {
  const step = Number(input.dataset.step);
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  const value = (Math.round(Number(input.value) / step) * step).toFixed(digits);
  input.nextElementSibling.textContent = String(Number(value));
  // One change at a time; the last one counts.
  page.wanted = { name, value: String(Number(value)) };
  if (page.isSetting) return;
  page.isSetting = true;
  try {
    while (page.wanted) {
      const { name: wanted, value: number } = page.wanted;
      page.wanted = null;
      editor.replace(await editing.ask("set", { scene: sceneNow(), name: wanted, value: number }, PATIENCE));
    }
    edited();
  } catch (trouble) {
    showTrouble(trouble);
  } finally {
    page.isSetting = false;
  }
}

/** Puts another scene into the editor. */
async function take(scene) {
  stopRun();
  page.scene = { name: scene.name, from: scene.from, files: scene.files ?? [] };
  if (scene.from) {
    try {
      const copied = await editing.ask("copy", { name: scene.from });
      page.scene.files = copied.files;
      scene.text ??= copied.content;
    } catch (trouble) {
      page.scene.from = null;
      if (scene.text === undefined) return showTrouble(trouble);
    }
  }
  editor.value = scene.text;
  at("shipped").value = scene.isShipped ? scene.from : "";
  at("verdict").replaceChildren();
  keep();
  if (await examine()) await begin();
}

/* The run. */

function stopRun() {
  running?.stop();
  running = null;
  page.state = "none";
  page.summary = null;
  at("summary").hidden = true;
  at("downloads").replaceChildren();
  at("facts").textContent = "";
  updateControls();
}

/** Starts a run at its first moment. Returns whether it could be started. */
function begin() {
  page.beginning = beginNow();
  return page.beginning;
}

async function beginNow() {
  stopRun();
  const examined = page.examined;
  if (!examined) return false;
  const engine = new Engine(program, hear);
  running = engine;
  page.text = editor.value;
  makeCurves(examined);
  try {
    await engine.ask("contacts", { isShown: at("contacts")?.checked ?? false });
    await engine.ask("start", { scene: sceneNow(), isLattice: examined.is_lattice }, 60_000);
    if (running !== engine) return false;
    page.state = "ready";
    updateControls();
    return true;
  } catch (trouble) {
    if (running === engine) showTrouble(trouble);
    return false;
  }
}

function makeCurves(examined) {
  const counts = { title: examined.is_lattice ? "Particles" : "Grains", curves: [{ name: "inside", of: (sample) => sample.inside }, { name: "out", of: (sample) => sample.out }] };
  const outflow = { title: "Outflow", unit: "grains/s", curves: [{ name: "", of: (sample) => sample.outflow }] };
  const energy = { title: "Energy", unit: "J", curves: [{ name: "kinetic", of: (sample) => sample.totals.kinetic + sample.totals.rotational }, { name: "elastic", of: (sample) => sample.totals.elastic }] };
  curves = new Curves(at("curves"), examined.is_lattice ? [counts] : [counts, outflow, energy], examined.is_lattice ? "steps" : "s");
}

/** What a worker tells by itself. */
function hear({ sample, picture, isLattice, isRunning, crash }) {
  if (crash) {
    crashed(`The run has stopped: ${crash} Your text is kept.`);
    running?.stop();
    running = null;
    page.state = "none";
    return updateControls();
  }
  showPicture(picture, isLattice);
  running?.drawn();
  showFacts(sample, isLattice);
  curves?.add(sample);
  page.events ??= sample.events;
  if (sample.status) over(sample);
  else if (!isRunning && page.state === "running") {
    page.state = "paused";
    announce(eventIn(sample) || "paused");
    updateControls();
  }
  page.events = sample.events;
}

/** The event that ended a run to the next event, in words. */
function eventIn({ events, is_reached: isReached }) {
  if (!isReached || !page.events) return "";
  const before = page.events;
  if (events.is_at_rest && !before.is_at_rest) return events.doors > before.doors ? "at rest, and the door opens" : "the grains have come to rest";
  if (events.doors > before.doors) return "a door begins to move";
  return events.is_flowing && !before.is_flowing ? "the first grain has left" : "";
}

function showPicture(picture, isLattice) {
  at("picture").hidden = !isLattice;
  live.canvas.hidden = isLattice;
  at("look").hidden = isLattice;
  at("legend").hidden = isLattice;
  if (!picture) return;
  if (isLattice) {
    const before = at("picture").src;
    at("picture").src = URL.createObjectURL(new Blob([picture], { type: "image/svg+xml" }));
    if (before) URL.revokeObjectURL(before);
    return;
  }
  try {
    const run = live.show(picture);
    showLook(run);
  } catch (error) {
    console.error(error);
  }
}

/** The choices of the player for this run, and the legend. */
function showLook(run) {
  const names = live.colourings.map((colouring) => colouring.name).join();
  const key = `${run.dimension} ${names} ${run.doors.length > 0}`;
  if (page.look !== key) {
    page.look = key;
    const isOn = at("contacts")?.checked ?? false;
    const options = live.colourings.map((colouring) => [colouring.key ?? colouring.name, `${colouring.name}${colouring.unit ? ` (${colouring.unit})` : ""}`]);
    const colour = select("Colour", options, live.wanted, (name) => {
      live.wanted = name;
      live.colouring = live.colourings.find((colouring) => (colouring.key ?? colouring.name) === name);
      live.view.setColouring(live.colouring);
      showLegend(live.view.run);
    });
    colour.box.value = live.colouring.key ?? live.colouring.name;
    const chains = checkbox("Force chains", isOn, (isShown) => {
      live.view.shown.bonds = isShown;
      running?.ask("contacts", { isShown });
      live.view.redraw();
    });
    chains.querySelector("input").id = "contacts";
    const zoom = (factor) => () => (live.view.camera.zoomBy(factor), live.view.redraw());
    const parts = [colour.element, chains];
    if (run.dimension === 3) parts.push(select("View", Object.keys(VIEWS).map((name) => [name, name]), "oblique", (name) => (live.view.camera.turnTo(...VIEWS[name]), live.view.redraw())).element);
    parts.push(button("−", "Zoom out", zoom(1 / 1.25)), button("+", "Zoom in", zoom(1.25)), button("⤢", "Show all", () => (live.view.camera.fit(), live.view.redraw())));
    at("look").replaceChildren(...parts);
  }
  showLegend(run);
}

function showLegend(run) {
  const colouring = live.colouring;
  const key = JSON.stringify([colouring.name, colouring.low, colouring.high, colouring.isAbove, [...new Set(run.speciesOf)], live.view.shown.bonds]);
  if (page.legend === key) return;
  page.legend = key;
  at("legend").replaceChildren(legend(colouring, run, live.view.shown));
}

function showFacts(sample, isLattice) {
  const moment = isLattice ? `step ${sample.steps}` : `${sample.time.toFixed(3)} s`;
  const counts = [["released", sample.released], ["inside", sample.inside], ["out", sample.out], ["lost", sample.lost]];
  const words = counts.filter(([name, count]) => count || name !== "lost").map(([name, count]) => `${count} ${name}`);
  const pace = sample.wall > 0.3 ? ` · ${shortNumber(sample.time / sample.wall)} ${isLattice ? "steps/s" : "× real time"}` : "";
  at("facts").replaceChildren(make("b", { textContent: moment }), `${words.join(" · ")} · step ${sample.steps}${pace}`);
}

function announce(words) {
  at("state").textContent = words;
  tell(words);
}

/** Ends a run: the program writes its last files. */
async function over(sample) {
  if (page.state === "over") return;
  page.state = "over";
  updateControls();
  announce(sample.failure ? `The run has failed: ${sample.failure}` : `The run is over: ${sample.status.replaceAll("_", " ")}`);
  await finish();
}

/** Ends the run, wherever it is, and shows its results. */
async function finish() {
  const engine = running;
  try {
    const words = await engine.ask("finish");
    if (running !== engine) return;
    page.state = "over";
    at("summary").textContent = words;
    at("summary").hidden = false;
    showDownloads(new Map(await engine.ask("files")));
  } catch (trouble) {
    showTrouble(trouble);
  }
  updateControls();
}

function showDownloads(files) {
  const { name } = page.scene;
  const single = SINGLE.filter((file) => files.has(file));
  at("downloads").replaceChildren(
    ...single.map((file) => make("button", { type: "button", textContent: file, onclick: () => download(`${name}-${file}`, [files.get(file)]) })),
    make("button", { type: "button", textContent: "All files (tar)", onclick: () => download(`${name}.tar`, tar(name, [...files]), "application/x-tar") }),
    make("button", { type: "button", textContent: "Report (HTML)", onclick: () => saveReport(name) }),
  );
}

async function saveReport(name) {
  tell("The report is being written …");
  try {
    download(`${name}.html`, [await running.ask("report")], "text/html");
    tell("");
  } catch (trouble) {
    tell(trouble.message);
  }
}

/* Controls. */

function updateControls() {
  const { state } = page;
  const isRunning = state === "running";
  const button = at("run");
  button.textContent = isRunning ? "❚❚ Pause" : "▶ Run";
  button.disabled = !isRunning && !page.examined;
  at("step").disabled = at("event").disabled = isRunning || !page.examined;
  at("restart").disabled = state === "none";
}

/** Makes the run ready that a button acts on: a new one, if the text has changed or the last run is over. */
async function ready() {
  if ((editor.value !== page.text || page.timer) && !(await examine())) return false;
  // It may just be starting.
  await page.beginning;
  if (editor.value === page.text && (page.state === "ready" || page.state === "paused")) return true;
  return begin();
}

/** Does what buttons ask for one after the other. */
function alone(act) {
  page.last = (page.last ?? Promise.resolve()).then(act).catch((trouble) => trouble?.message && showTrouble(trouble));
  return page.last;
}

async function go(toEvent) {
  if (page.state === "running") return pause();
  if (!(await ready())) return;
  page.state = "running";
  updateControls();
  announce("running");
  running.ask("run", { speed: Number(at("speed").value), toEvent });
}

async function pause() {
  await running.ask("pause");
  if (page.state === "running") page.state = "paused";
  updateControls();
  announce("paused");
  if (page.state === "paused" && !at("end")) {
    at("downloads").replaceChildren(make("button", { type: "button", id: "end", textContent: "End the run here, for its files", onclick: finish }));
  }
}

at("run").addEventListener("click", () => alone(() => go(false)));
at("event").addEventListener("click", () => alone(() => go(true)));
at("step").addEventListener("click", () => alone(async () => (await ready()) && running.ask("step")));
at("restart").addEventListener("click", () => alone(async () => (await examine()) && begin()));
at("speed").addEventListener("change", () => page.state === "running" && running.ask("run", { speed: Number(at("speed").value), toEvent: false }));
at("shipped").addEventListener("change", () => at("shipped").value && take({ name: at("shipped").value, from: at("shipped").value, isShipped: true }));
at("link").addEventListener("click", async () => {
  const { name, from } = page.scene;
  location.replace(await toFragment({ name, from, text: editor.value }));
  page.fragment = location.hash;
  try {
    await navigator.clipboard.writeText(location.href);
    tell("The link is in the clipboard, and in the address bar.");
  } catch {
    tell("The link is in the address bar.");
  }
});
at("open").addEventListener("click", () => at("files").click());
at("files").addEventListener("change", async () => {
  const chosen = await Promise.all([...at("files").files].map(async (file) => [file.name, new Uint8Array(await file.arrayBuffer())]));
  const scene = chosen.find(([name]) => name.endsWith(".ron"));
  const others = chosen.filter((file) => file !== scene);
  at("files").value = "";
  if (scene) return take({ name: safeName(scene[0].slice(0, -4)), from: null, text: new TextDecoder().decode(scene[1]), files: others });
  page.scene.files = [...page.scene.files.filter(([name]) => !others.some(([other]) => other === name)), ...others];
  tell(`${others.length} file${others.length > 1 ? "s" : ""} beside the scene`);
  preview();
});
/** Keys outside of the text: space runs and pauses, a point steps. */
document.addEventListener("keydown", (event) => {
  const isFree = event.target === document.body || event.target === live.canvas;
  if (!isFree || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === " ") at("run").click();
  else if (event.key === ".") at("step").click();
  else return;
  event.preventDefault();
});
addEventListener("hashchange", () => location.hash !== page.fragment && openLink());

/** Opens the scene of the link. Returns whether there is one. */
async function openLink() {
  page.fragment = location.hash;
  try {
    const scene = await fromFragment(location.hash);
    if (scene) await take(scene);
    return Boolean(scene);
  } catch (error) {
    crashed(`The scene of this link cannot be opened: ${error.message}.`);
    return false;
  }
}

(async () => {
  for (const [value, name] of SPEEDS) at("speed").append(make("option", { value, textContent: name }));
  updateControls();
  const scenes = await editing.ask("shipped");
  at("shipped").append(make("option", { value: "", textContent: "your own scene" }));
  for (const { name, line } of scenes) at("shipped").append(make("option", { value: name, textContent: `${name}: ${line}` }));
  if (await openLink()) return;
  const last = kept();
  if (last) await take(last);
  else await take({ name: "silo1", from: "silo1", isShipped: true });
})();
