#!/usr/bin/env bash
# Results of the silo over seeds: uniform grains against mixtures. Prints mean +- standard error over the seeds.
#   docs/measure/seeds.sh [SEEDS]                    (default 5; about 10 s a seed)
#   SILOFLOW=PATH docs/measure/seeds.sh [SEEDS]      (with a built program, instead of building one)
#   JSON=PATH docs/measure/seeds.sh [SEEDS]          (writes the numbers to a file too)
# A run that loses grains ends with exit status 1 and `"failure": null`. It counts, and the table shows the lost grains.
# Every other failure stops the script.
set -euo pipefail
cd "$(dirname "$0")/../.."
seeds=${1:-5}
[[ $seeds =~ ^[1-9][0-9]*$ ]] || { echo "seeds.sh: SEEDS must be a positive integer, not '$seeds'" >&2; exit 2; }
if [[ -z ${SILOFLOW:-} ]]; then
  cargo build --release --quiet
  SILOFLOW=target/release/siloflow
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

simulate() { # scene, seed: runs it into $out/run
  local status=0
  rm -rf "$out/run"
  "$SILOFLOW" run "scenes/$1.ron" --seed "$2" --set pictures=None --set on_loss=Continue --out "$out/run" --force --quiet >/dev/null || status=$?
  if ((status == 0)); then return; fi
  if ((status == 1)) && grep -q '"failure": null' "$out/run/summary.json" 2>/dev/null; then return; fi
  echo "seeds.sh: $SILOFLOW run scenes/$1.ron --seed $2 failed with exit status $status" >&2
  exit 1
}

for scene in silo1 silo1-mixture silo1-polydisperse; do
  for ((seed = 1; seed <= seeds; seed++)); do
    simulate "$scene" "$seed"
    # A grain enters at height 3.9 m with 2 m/s, so its energy is m (g 3.9 + 2^2/2): this gives the mean mass of the grains.
    # The key `released` occurs twice: first the number of grains, then their energy in J.
    tr -d ' ",' <"$out/run/summary.json" | awk -F: -v scene="$scene" '
        $1 == "released" && $1 in value { energy = $2 }
        !($1 in value) { value[$1] = $2 }
        END {
          mass = energy / (9.81 * 3.9 + 2.0) / value["released"]
          print scene, value["fill_height_m"], value["packing_fraction"], value["rest_time_s"] - 49.95,
                value["duration_s"], value["rate_per_s"], value["rate_per_s"] * mass, value["max_overlap_ratio"], value["lost"]
        }' >>"$out/rows"
  done
done
awk -v json="${JSON:-/dev/null}" '
  BEGIN { split("- height packing rest discharge rate mass_rate overlap", name, " ") }
  !($1 in n) { order[++scenes] = $1 }
  { n[$1]++; for (i = 2; i <= NF; i++) { sum[$1, i] += $i; square[$1, i] += $i * $i } }
  END {
    printf "%-20s %18s %18s %18s %18s %18s %18s %18s %8s\n", "scene", "fill height, m", "packing fraction",
           "rest after last, s", "discharge, s", "rate, grains/s", "rate, kg/s", "overlap/R", "lost"
    printf "{" > json
    for (k = 1; k <= scenes; k++) {
      s = order[k]
      printf "%-20s", s
      separator = (k > 1) ? ", " : ""
      printf "%s\"%s\": {\"lost\": %d", separator, s, sum[s, 9] > json
      for (i = 2; i <= 8; i++) {
        mean = sum[s, i] / n[s]; variance = square[s, i] / n[s] - mean * mean
        error = sqrt((variance > 0 ? variance : 0) / (n[s] > 1 ? n[s] - 1 : 1))
        printf " %9.4f +- %.4f", mean, error
        printf ", \"%s\": {\"mean\": %.6f, \"error\": %.6f}", name[i], mean, error > json
      }
      printf " %8d\n", sum[s, 9]
      printf "}" > json
    }
    print "}" > json
  }' "$out/rows"
