// Runs the pinned scenes of tests/data/hashes.csv in Node and compares their hashes with those of the native program.
//
//     node crates/web/node/pins.mjs target/wasm32-wasip1/web/siloflow.wasm [WORDS OF SCENES ...]
//
// The program may also be a native one. A row that cannot be run has to be refused with the pinned code. The exit status is 1 if any row differs.

import { spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const [program, ...words] = process.argv.slice(2);
const here = fileURLToPath(new URL(".", import.meta.url));
const root = resolve(here, "../../..");
mkdirSync(join(root, "target"), { recursive: true });
const work = mkdtempSync(join(root, "target/pins-"));

/** The fields of a line of CSV. */
function fields(line) {
  const found = [...line.matchAll(/("(?:[^"]|"")*"|[^,]*)(?:,|$)/g)].slice(0, 5);
  return found.map(([, field]) => (field.startsWith('"') ? field.slice(1, -1).replaceAll('""', '"') : field));
}

/** The hash of a row, or the reason why there is none. */
function hashOf([scene, scheme, until, set]) {
  const settings = set.split("; ").filter(Boolean).flatMap((setting) => ["--set", setting]);
  if (scheme !== "LatticeGas") settings.push("--set", `integrator=${scheme}`);
  const args = ["--quiet", "run", join("scenes", scene), "--out", join(relative(root, work), "run"), "--force", "--until", until, "--json", ...settings];
  const inNode = [process.execPath, "--no-warnings", join(here, "siloflow.mjs")];
  const [command, ...before] = program.endsWith(".wasm") ? [...inNode, resolve(program)] : [resolve(program)];
  const done = spawnSync(command, [...before, ...args], { cwd: root, encoding: "utf8" });
  if (done.status === 2) return `refused ${done.stderr.match(/\w+::\w+/)?.[0]}`;
  return done.stdout.match(/"state_hash": "(\w+)"/)?.[1] ?? `status ${done.status ?? done.signal}: ${done.stderr.slice(-300)}`;
}

const rows = readFileSync(join(root, "tests/data/hashes.csv"), "utf8").trim().split("\n").slice(2).map(fields);
const wanted = rows.filter(([scene]) => !words.length || words.some((word) => scene.includes(word)));
let equal = 0;
for (const row of wanted) {
  const start = performance.now();
  const found = hashOf(row);
  const seconds = ((performance.now() - start) / 1000).toFixed(1);
  if (found === row[4]) equal++;
  else console.log(`${row.slice(0, 4).join(" ")}: ${seconds} s, expected ${row[4]}, got ${found}`);
}
rmSync(work, { recursive: true });
console.log(`${equal} of ${wanted.length} rows have equal hashes`);
process.exitCode = equal === wanted.length ? 0 : 1;
