// Builds the page: one HTML file with the program, the worker, the player of reports and the scripts of `page/`.
//
//     npm ci --ignore-scripts
//     node build.mjs [PROGRAM.wasm] [PAGE.html]
//
// The program is what `cargo build --release --target wasm32-wasip1` makes here, with RUSTFLAGS="-C target-feature=+simd128".

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import { build, transformSync } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const PROGRAM = process.argv[2] ?? join(here, "target/wasm32-wasip1/release/siloflow_web.wasm");
const PAGE = process.argv[3] ?? join(here, "dist/siloflow.html");
const PLAYER = join(here, "../../crates/results/src/report/player");
/** Scripts of the player that a live view needs. */
const PLAYER_SCRIPTS = ["decode", "colours", "camera", "shaders", "walls", "occlusion", "renderer", "flat_renderer", "view", "form", "moments", "pointer"];
const PAGE_SCRIPTS = ["engine", "editor", "link", "downloads", "curves", "live", "state", "scene", "parameters", "run", "look", "main"];

const brotli = (bytes) => brotliCompressSync(bytes, { params: { [constants.BROTLI_PARAM_LGWIN]: 24, [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length } });
const read = (...path) => readFileSync(join(...path), "utf8");
/** Most bytes of the page, as a server sends it. */
const LIMITS = { gzip: 4e6, brotli: 3e6 };

const worker = await build({ entryPoints: [join(here, "page/worker.js")], bundle: true, minify: true, format: "iife", write: false, legalComments: "none" });
const scripts = [...PLAYER_SCRIPTS.map((name) => read(PLAYER, "script", `${name}.js`)), ...PAGE_SCRIPTS.map((name) => read(here, "page", `${name}.js`))];
const script = transformSync(`(() => {\n"use strict";\n${scripts.join("\n")}\n})();`, { minifyWhitespace: true, legalComments: "none" }).code;
const style = transformSync(`${read(PLAYER, "player.css")}\n${read(here, "page/page.css")}`, { loader: "css", minifyWhitespace: true }).code;
const wasm = readFileSync(PROGRAM);
const packed = brotli(wasm);
const parts = { STYLE: style, SCRIPT: script, WORKER: worker.outputFiles[0].text, PROGRAM: packed.toString("base64") };
for (const [name, text] of Object.entries(parts)) {
  if (/<\/(script|style)/i.test(text)) throw new Error(`${name} would end its element`);
}
const page = read(here, "page/page.html").replace(/@([A-Z]+)@/g, (_, name) => parts[name]);
mkdirSync(dirname(PAGE), { recursive: true });
writeFileSync(PAGE, page);

const sizesOf = (bytes, packed = brotli(bytes)) => ({ plain: bytes.length, gzip: gzipSync(bytes, { level: 9 }).length, brotli: packed.length });
const sizes = sizesOf(Buffer.from(page));
for (const [name, found] of [["the program", sizesOf(wasm, packed)], [PAGE, sizes]]) {
  console.log(`${name}: ${found.plain} bytes, ${found.gzip} with gzip, ${found.brotli} with brotli`);
}
for (const [way, most] of Object.entries(LIMITS)) {
  if (sizes[way] > most) throw new Error(`the page takes ${sizes[way]} bytes with ${way}, more than ${most}`);
}
