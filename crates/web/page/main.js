// Controls of the page, and its beginning.

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
  page.last = (page.last ?? Promise.resolve()).then(act).catch(showTrouble);
  return page.last;
}

async function go(toEvent) {
  if (page.state === "running") return pause();
  if (!(await ready())) return;
  page.state = "running";
  updateControls();
  tell("running");
  running.ask("run", { speed: Number(at("speed").value), toEvent }).catch(showTrouble);
}

async function pause() {
  await running.ask("pause");
  if (page.state === "running") page.state = "paused";
  updateControls();
  tell("paused");
  if (page.state === "paused" && !at("end")) {
    at("downloads").replaceChildren(make("button", { type: "button", id: "end", textContent: "End the run here, for its files", onclick: finish }));
  }
}

at("run").addEventListener("click", () => alone(() => go(false)));
at("event").addEventListener("click", () => alone(() => go(true)));
at("step").addEventListener("click", () => alone(async () => (await ready()) && running.ask("step")));
at("restart").addEventListener("click", () => alone(async () => (await examine()) && begin()));
at("speed").addEventListener("change", () => page.state === "running" && running.ask("run", { speed: Number(at("speed").value), toEvent: false }).catch(showTrouble));
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
  let scenes = [];
  try {
    scenes = await editing.ask("shipped");
  } catch (trouble) {
    editor.value = kept()?.text ?? "";
    return crashed(`The program has failed: ${trouble.message ?? "it cannot be started"} Your text is kept.`);
  }
  at("shipped").append(make("option", { value: "", textContent: "your own scene" }));
  for (const { name, line } of scenes) at("shipped").append(make("option", { value: name, textContent: `${name}: ${line}` }));
  if (await openLink()) return;
  const last = kept();
  if (last) await take(last);
  else await take({ name: "silo1", from: "silo1", isShipped: true });
})();
