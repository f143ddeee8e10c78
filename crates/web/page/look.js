// The picture of the run, its legend and its numbers.

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
      running?.ask("contacts", { isShown }).catch(showTrouble);
      live.view.redraw();
    });
    chains.querySelector("input").id = "contacts";
    const zoom = (factor) => () => (live.view.camera.zoomBy(factor), live.view.redraw());
    const parts = [colour.element, chains];
    if (run.dimension === 3) parts.push(select("View", Object.keys(VIEWS).map((name) => [name, name]), "oblique", (name) => (live.view.camera.turnTo(...VIEWS[name]), live.view.redraw())).element);
    parts.push(make("span", {}, [button("−", "Zoom out", zoom(1 / 1.25)), button("+", "Zoom in", zoom(1.25)), button("⤢", "Show all", () => (live.view.camera.fit(), live.view.redraw()))]));
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
