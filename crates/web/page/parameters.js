// Sliders for the parameters of a scene.

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
