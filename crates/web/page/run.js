// The run: it starts, tells what it computes, and ends with results.

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
    tell(eventIn(sample) || "paused");
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

/** Ends a run: the program writes its last files. */
async function over(sample) {
  if (page.state === "over") return;
  page.state = "over";
  updateControls();
  tell(sample.failure ? `The run has failed: ${sample.failure}` : `The run is over: ${sample.status.replaceAll("_", " ")}`);
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
