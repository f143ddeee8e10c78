// The scene in the editor: it is kept, examined, and replaced.

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
  if (trouble.isStopped) return;
  const isHere = trouble.line && (!trouble.file || trouble.file.endsWith(".ron"));
  editor.mark(isHere ? trouble : null);
  const place = trouble.line ? `${isHere ? "Line" : `${trouble.file}, line`} ${trouble.line}, column ${trouble.column}: ` : "";
  const parts = [make("b", { textContent: place }), trouble.message];
  if (trouble.help) parts.push(make("span", { className: "help", textContent: trouble.help }));
  if (isHere) parts.push(make("button", { type: "button", id: "go", textContent: "Go there", onclick: () => editor.go() }));
  at("verdict").replaceChildren(make("div", { className: "bad" }, parts));
  at("estimates").hidden = true;
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
