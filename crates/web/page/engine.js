// The program in a worker. A worker that has failed, or does not answer, is replaced by a new one.

/** Unpacks the embedded program, Brotli in base64, in a worker of its own, and compiles it. */
async function unpackProgram() {
  const letters = atob(document.getElementById("program").textContent.trim());
  const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  // A worker that cannot be started answers nothing.
  const unpacking = new Engine(null, ({ crash }) => crashed(`The program could not be unpacked: ${crash}`));
  unpacking.open();
  try {
    return await WebAssembly.compile(await unpacking.post("unpack", { packed }));
  } finally {
    unpacking.stop();
  }
}

class Engine {
  /** `module` is a promise of the compiled program; `hear` gets what the worker tells by itself. */
  constructor(module, hear = () => {}) {
    this.module = module;
    this.hear = hear;
    this.waiting = new Map();
    this.count = 0;
  }

  open() {
    const address = URL.createObjectURL(new Blob([document.getElementById("worker").textContent], { type: "text/javascript" }));
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }) => this.receive(data);
    this.worker.onerror = (event) => this.receive({ crash: event.message || "the worker could not be started" });
  }

  start() {
    this.open();
    this.loaded = this.module.then((module) => this.post("load", { module }));
    this.loaded.catch(() => {});
  }

  receive({ id, result, trouble, ...told }) {
    const waiting = this.waiting.get(id);
    if (!waiting) return this.hear(told);
    this.waiting.delete(id);
    clearTimeout(waiting.timer);
    if (trouble) waiting.reject(trouble);
    else waiting.resolve(result);
  }

  post(what, rest, patience = Infinity) {
    return new Promise((resolve, reject) => {
      const id = ++this.count;
      const giveUp = () => {
        this.waiting.delete(id);
        reject({ message: `The program did not answer within ${patience / 1000} s.`, help: "make the scene smaller, or run it with the program on your machine", isCrash: true });
      };
      const timer = Number.isFinite(patience) ? setTimeout(giveUp, patience) : 0;
      this.waiting.set(id, { resolve, reject, timer });
      this.worker.postMessage({ id, what, ...rest });
    });
  }

  /** Asks the program; rejects with its trouble. */
  async ask(what, rest = {}, patience = Infinity) {
    if (!this.worker) this.start();
    try {
      await this.loaded;
      return await this.post(what, rest, patience);
    } catch (trouble) {
      if (trouble.isCrash) this.stop();
      throw trouble;
    }
  }

  /** Tells the worker that its last picture is on the screen. */
  drawn() {
    requestAnimationFrame(() => setTimeout(() => this.worker?.postMessage({ what: "drawn" })));
  }

  /** Ends the worker. What is being asked is rejected, so that nobody waits for ever. */
  stop() {
    this.worker?.terminate();
    this.worker = null;
    for (const { reject, timer } of this.waiting.values()) {
      clearTimeout(timer);
      reject({ isStopped: true });
    }
    this.waiting.clear();
  }
}
