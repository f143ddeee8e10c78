// The worker: the program with its file system in memory. It answers the page, and steps a run in slices, so that a message such as "pause"
// arrives between two of them.

import { decompress } from "brotli/decompress";
import { Directory, File, OpenFile, PreopenDirectory, WASI, ConsoleStdout } from "@bjorn3/browser_wasi_shim";

/** Milliseconds of a slice of steps. */
const SLICE = 12;
/** Milliseconds between two pictures. */
const BETWEEN_PICTURES = 30;

/** Files grow by half of their length, not by each write. */
OpenFile.prototype.fd_write = function (data) {
  const { file } = this;
  const start = Number(this.file_pos);
  const end = start + data.byteLength;
  if (end > file.data.byteLength) {
    if (end > file.data.buffer.byteLength - file.data.byteOffset) {
      const larger = new Uint8Array(Math.max(end, Math.ceil(1.5 * file.data.byteLength), 256));
      larger.set(file.data);
      file.data = larger;
    }
    file.data = new Uint8Array(file.data.buffer, file.data.byteOffset, end);
  }
  file.data.set(data, start);
  this.file_pos = BigInt(end);
  return { ret: 0, nwritten: data.byteLength };
};

const text = new TextDecoder();
const bytes = new TextEncoder();
const scenes = new Directory(new Map());
const root = new PreopenDirectory("/", new Map([["scene", scenes]]));
let messages = "";
let program;

async function load(module) {
  const note = (line) => (messages = `${messages}${line}\n`.slice(-4000));
  const wasi = new WASI(["siloflow"], [], [new OpenFile(new File([])), ConsoleStdout.lineBuffered(note), ConsoleStdout.lineBuffered(note), root], { debug: false });
  const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi.wasiImport });
  wasi.initialize(instance);
  program = instance.exports;
}

/** Calls a function of the program; its answer as bytes. Throws the program's own trouble. */
function call(name, request = "", ...numbers) {
  root.dir.contents.set("request", new File(bytes.encode(request)));
  const isDone = program[name](...numbers);
  const answer = new Uint8Array(program.memory.buffer, program.answer_address(), program.answer_length()).slice();
  if (!isDone) throw { trouble: JSON.parse(text.decode(answer)) };
  return answer;
}

const inWords = (...of) => text.decode(call(...of));
const asJson = (...of) => JSON.parse(inWords(...of));

/** Puts the files of a scene in place; returns its path. */
function place({ name, content, files }) {
  for (const [file, data] of files) scenes.contents.set(file, new File(data));
  scenes.contents.set(`${name}.ron`, new File(bytes.encode(content)));
  return `/scene/${name}.ron`;
}

/** All files in a directory of the file system, as pairs of path and bytes. */
function filesIn(directory, before = "") {
  return [...directory.contents].flatMap(([name, entry]) =>
    entry instanceof Directory ? filesIn(entry, `${before}${name}/`) : [[before + name, entry.data]]);
}

const runFiles = () => filesIn(root.dir.contents.get("run") ?? new Directory(new Map())).filter(([name]) => name !== ".siloflow");

/** The latest picture that a run of the lattice gas has drawn. */
function latestPicture() {
  const pictures = root.dir.contents.get("run")?.contents.get("frames")?.contents ?? new Map();
  const name = [...pictures.keys()].filter((file) => file.endsWith(".svg")).sort().at(-1);
  return name ? pictures.get(name).data.slice() : null;
}

/** `isDrawn` is whether the page has drawn the last picture: a slow one gets fewer of them, so that it hears its user. */
const run = { isLattice: false, contacts: false, pace: null, wish: 0, shown: 0, isDrawn: true };

function show(sample) {
  const picture = run.isLattice ? latestPicture() : call("picture", "", Number(run.contacts));
  Object.assign(run, { shown: performance.now(), isDrawn: false });
  postMessage({ sample, picture, isLattice: run.isLattice, isRunning: run.wish > 0 }, picture ? [picture.buffer] : []);
}

/** Steps once more, unless the run is paused. `pace` has the speed (simulated seconds a second), and its time at a moment. */
function slice(wish) {
  if (wish !== run.wish || !run.pace) return;
  const { speed, toEvent, moment, start } = run.pace;
  const now = performance.now();
  const target = Number.isFinite(speed) ? start + ((now - moment) / 1000) * speed : Infinity;
  if (run.time >= target) {
    next(wish, 4);
    return;
  }
  const began = performance.now();
  const sample = asJson("advance", "", SLICE, target, Number(toEvent));
  run.stepping += performance.now() - began;
  run.time = sample.time;
  // A slow machine falls behind: the pace begins again.
  if (Number.isFinite(speed) && target - sample.time > speed) Object.assign(run.pace, { moment: performance.now(), start: sample.time });
  const isEvent = toEvent && sample.is_reached;
  if (sample.status || isEvent) run.wish = 0;
  if (sample.status || isEvent || (run.isDrawn && performance.now() - run.shown > BETWEEN_PICTURES)) show({ ...sample, wall: run.stepping / 1000 });
  if (run.wish) next(wish, 0);
}

/** Messages that have come are handled before the next slice. A channel has no delay of a few milliseconds, as timers have. */
const channel = new MessageChannel();
channel.port1.onmessage = ({ data }) => guarded(() => slice(data));
function next(wish, delay) {
  if (delay) setTimeout(() => guarded(() => slice(wish)), delay);
  else channel.port2.postMessage(wish);
}

let wishes = 0;
const commands = {
  unpack: ({ packed }) => decompress(packed),
  load: ({ module }) => load(module),
  shipped: () => asJson("shipped"),
  copy: ({ name }) => {
    const content = inWords("copy", name);
    return { content, files: filesIn(scenes).filter(([file]) => file !== `${name}.ron`) };
  },
  examine: (scene) => asJson("examine", place(scene)),
  set: ({ scene, name, value }) => inWords("set", `${place(scene)}\n${name}\n${value}\n`),
  start: ({ scene, isLattice }) => {
    call("start", place(scene));
    Object.assign(run, { isLattice, stepping: 0 });
    const sample = asJson("sample");
    run.time = sample.time;
    show({ ...sample, wall: 0 });
  },
  run: ({ speed, toEvent }) => {
    run.wish = ++wishes;
    run.pace = { speed, toEvent, moment: performance.now(), start: run.time };
    next(run.wish, 0);
  },
  pause: () => {
    if (!run.wish) return;
    run.wish = 0;
    show({ ...asJson("sample"), wall: run.stepping / 1000 });
  },
  step: () => {
    run.wish = 0;
    const sample = asJson("advance", "", 0, -1, 0);
    run.time = sample.time;
    show({ ...sample, wall: run.stepping / 1000 });
  },
  contacts: ({ isShown }) => {
    run.contacts = isShown;
  },
  finish: () => inWords("finish"),
  files: () => runFiles().map(([name, data]) => [name, data.slice()]),
  report: () => inWords("report"),
};

/** Tells the page of troubles that stop the program. */
function guarded(act) {
  try {
    return act();
  } catch (error) {
    if (error?.trouble) throw error;
    run.wish = 0;
    postMessage({ crash: messages.trim() || String(error) });
    throw error;
  }
}

onmessage = async ({ data: { id, what, ...rest } }) => {
  if (what === "drawn") {
    run.isDrawn = true;
    return;
  }
  try {
    const result = await guarded(() => commands[what](rest));
    postMessage({ id, result });
  } catch (error) {
    postMessage({ id, trouble: error?.trouble ?? { message: messages.trim() || String(error), isCrash: true } });
  }
};
