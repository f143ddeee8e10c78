#!/usr/bin/env bash
# The silo's figures over seeds: uniform grains against mixtures. Prints mean +- standard error over the seeds.
#   docs/measure/seeds.sh [SEEDS]        (default 5; about 10 s a seed)
set -euo pipefail
cd "$(dirname "$0")/../.."
seeds=${1:-5}
cargo build --release --quiet
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for scene in silo1 silo1-mixture silo1-polydisperse; do
  for ((seed = 1; seed <= seeds; seed++)); do
    target/release/siloflow run "scenes/$scene.ron" --seed "$seed" --set pictures=None --set on_loss=Continue \
      --out "$out/run" --quiet --json >"$out/summary" || true # a seed that loses a grain counts, and is shown
    tr -d ' ",' <"$out/summary" | awk -F: -v scene="$scene" '
        { value[$1] = $2 }
        END {
          rest = value["rest_time_s"] - 49.95
          print scene, value["fill_height_m"], value["packing_fraction"], rest, value["duration_s"], value["rate_per_s"],
                value["max_overlap_ratio"], value["lost"]
        }'
  done
done | awk '
  { n[$1]++; for (i = 2; i <= NF; i++) { sum[$1, i] += $i; square[$1, i] += $i * $i } }
  END {
    printf "%-20s %18s %18s %18s %18s %18s %18s %8s\n", "scene", "fill height, m", "packing fraction", "rest after last, s",
           "discharge, s", "rate, grains/s", "overlap/R", "lost"
    for (s in n) {
      printf "%-20s", s
      for (i = 2; i <= 7; i++) {
        mean = sum[s, i] / n[s]; variance = square[s, i] / n[s] - mean * mean
        error = sqrt((variance > 0 ? variance : 0) / (n[s] > 1 ? n[s] - 1 : 1))
        printf " %9.4f +- %.4f", mean, error
      }
      printf " %8d\n", sum[s, 8]
    }
  }'
