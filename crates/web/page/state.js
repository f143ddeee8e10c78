// What the page knows: the scene in the editor, and the run.

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
