// The command line, compiled to WebAssembly, in Node. The program sees the working directory alone, so paths are below it.
//
//     node --no-warnings crates/web/node/siloflow.mjs PROGRAM.wasm run scenes/silo1.ron --out out/silo1

import { readFile } from "node:fs/promises";
import { WASI } from "node:wasi";

const [program, ...args] = process.argv.slice(2);
const wasi = new WASI({ version: "preview1", args: ["siloflow", ...args], preopens: { "/": process.cwd() } });
const { instance } = await WebAssembly.instantiate(await readFile(program), wasi.getImportObject());
process.exitCode = wasi.start(instance);
