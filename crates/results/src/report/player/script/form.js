// Controls of the player.

/** Makes an element with properties, attributes (names with a dash) and children. */
function make(tag, properties = {}, children = []) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.includes("-") || name === "role" || name === "for") element.setAttribute(name, value);
    else element[name] = value;
  }
  element.append(...children);
  return element;
}

function button(text, label, act) {
  return make("button", { type: "button", textContent: text, title: label, "aria-label": label, onclick: act });
}

let controls = 0;

/** A control with a label before it. */
function labelled(text, box) {
  box.id = `sfp-${++controls}`;
  return { box, element: make("div", { className: "sfp-field" }, [make("label", { for: box.id, textContent: text }), box]) };
}

/** A select with its label; `options` are pairs of value and text. */
function select(text, options, chosen, act) {
  const box = make("select", { onchange: () => act(box.value) });
  for (const [value, name] of options) box.append(make("option", { value, textContent: name, selected: value === chosen }));
  return labelled(text, box);
}

/** A slider with its label. */
function slider(text, high, act) {
  const box = make("input", { type: "range", min: 0, max: high, step: 1, value: 0, oninput: () => act(Number(box.value)) });
  return labelled(text, box);
}

function checkbox(text, isOn, act) {
  const box = make("input", { type: "checkbox", checked: isOn, onchange: () => act(box.checked) });
  return make("label", { className: "sfp-check" }, [box, text]);
}

/** A legend of colours: swatches of species, or a bar with ticks; then walls and force chains, as far as they are shown. */
function legend(colouring, run, shown) {
  const list = make("div", { className: "sfp-legend" });
  const swatch = (colour, text, form = "disc") => {
    const mark = make("i", { className: `sfp-${form}` });
    mark.style.setProperty("--mark", colour);
    list.append(make("span", {}, [mark, text]));
  };
  if (colouring.isSpecies) {
    const present = new Set(run.speciesOf.filter((_, particle) => run.kinds[particle] === 0));
    run.species.forEach(([name, colour], number) => present.has(number) && swatch(colour, name));
  } else {
    list.append(colourBar(colouring));
  }
  const kinds = new Set(run.kinds);
  if (kinds.has(1)) swatch(run.wall_colours[0], "wall grains");
  if (kinds.has(2)) swatch(run.wall_colours[1], "door grains");
  const surfaces = run.dimension === 3 ? run.surface_colours : run.wall_colours;
  if (shown.walls && run.doors.includes(false)) swatch(surfaces[0], "walls", "line");
  if (shown.walls && run.doors.includes(true)) swatch(surfaces[1], "doors", "line");
  if (shown.bonds) {
    const width = `normal force, drawn from ${shortNumber(run.forces.low)} N, widest from ${shortNumber(run.forces.high)} N`;
    swatch("var(--ink)", width, "line");
    if (run.hasSliding) swatch(SLIDING, "sliding contact", "line");
  }
  return list;
}

function colourBar(colouring) {
  const { low, high } = colouring;
  const stops = [0, 32, 64, 96, 127, 159, 191, 222, 254].map((level) => `#${colouring.palette.slice(6 * level, 6 * level + 6)}`);
  const strip = make("div", { className: "sfp-strip" });
  strip.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  const scale = make("div", { className: "sfp-ticks" });
  const share = (number) => (colouring.isRoot ? Math.sqrt((number - low) / (high - low)) : (number - low) / (high - low));
  // On a scale of roots, small numbers have more room.
  const numbers = colouring.isRoot ? [low, ...ticks(low, low + (high - low) / 9, 2).slice(1), ...ticks(low, high, 3).slice(1)] : ticks(low, high, 5);
  for (const number of numbers) {
    const tick = make("span", { textContent: shortNumber(number) });
    tick.style.left = `${100 * share(number)}%`;
    scale.append(tick);
  }
  const unit = colouring.unit ? ` (${colouring.unit})` : "";
  const above = colouring.isAbove ? `; up to ${shortNumber(colouring.largest)} in the last colour` : "";
  const text = make("div", { className: "sfp-title", textContent: `${colouring.name}${unit}${above}` });
  return make("div", { className: "sfp-bar" }, [text, strip, scale]);
}
