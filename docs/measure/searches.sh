#!/usr/bin/env bash
# Time of the neighbour searches on beds at rest: against N at L = 0.25 m, and against L at N = 1000. R = 0.028 m.
# Each time is the median of three runs of STEPS steps; the searches alternate. Every failed run stops the script.
#   docs/measure/searches.sh [STEPS]                 (default 1000; about three minutes)
#   SILOFLOW=PATH docs/measure/searches.sh [STEPS]   (with a built program, instead of building one)
# Pair distances and instructions, which do not depend on the load of the machine: docs/measure/searches.py.
set -euo pipefail
cd "$(dirname "$0")/../.."
steps=${1:-1000}
if [[ -z ${SILOFLOW:-} ]]; then
  cargo build --release --quiet
  SILOFLOW=target/release/siloflow
fi
run=$SILOFLOW
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

failed() { # what failed
  echo "searches.sh: $1 failed" >&2
  exit 1
}
bed() { # N: makes a bed of N grains at rest
  $run run scenes/silo1.ron --quiet --force --out "$out/bed$1" --set spawner.count="$1" --set 'spawner.radius=Fixed(0.028)' \
    --set spawner.interval=0.04 --set rest.stop=true --set pictures=None >"$out/log" || failed "the bed of $1 grains"
}
ns() { # N, search: prints ns per particle-step, and the hash of the state
  $run run scenes/silo1.ron --quiet --force --json --out "$out/run" --set spawner.count=0 --set pictures=None --set rest=None \
    --set bed=None --set door=None --set "grains=(file: \"$out/bed$1/state.csv\")" --set "neighbours=$2" \
    --set 'series=(interval: 1.0e3)' --until "$(awk "BEGIN { print $steps * 1e-3 }")" >"$out/summary" || return
  tr -d ' ",' <"$out/summary" |
    awk -F: '$1 == "particle_steps_per_s" { ns = 1e9 / $2 } $1 == "state_hash" { print ns, $2 }'
}
compare() { # N, searches...: prints the medians, the ratio of the first to each, and whether all end in the same state
  local n=$1 search measured; shift
  : >"$out/rows"
  for _ in 1 2 3; do
    for search in "$@"; do
      measured=$(ns "$n" "$search") || failed "$search with $n grains"
      [[ -n $measured ]] || failed "reading the summary of $search with $n grains"
      echo "$search|$measured" >>"$out/rows"
    done
  done
  awk -F'[| ]' -v n="$n" '
      { line = $0; sub(/\|.*/, "", line); split(substr($0, length(line) + 2), v, " ")
        if (!(line in count)) order[++searches] = line
        t[line, ++count[line]] = v[1]; if (hash == "") hash = v[2]; else if (hash != v[2]) differ = 1 }
      function median(s) { a = t[s, 1]; b = t[s, 2]; c = t[s, 3]
        return a > b ? (b > c ? b : (a > c ? c : a)) : (a > c ? a : (b > c ? c : b)) }
      END { for (i = 1; i <= searches; i++)
          printf "%6d  %-28s %9.1f ns  %6.1f times\n", n, order[i], median(order[i]), median(order[1]) / median(order[i])
        print differ ? "        states differ!" : "        same state, to the last bit"; exit differ }' "$out/rows"
}
printf "%6s  %-28s %9s     %s\n" N search "per particle-step" "speed-up over the first"
for n in 250 500 1000 2000; do
  bed "$n"
  compare "$n" AllPairs 'Cells(size: 0.25)' 'VerletList(skin: 0.04)'
done
compare 1000 AllPairs 'Cells(size: 0.06)' 'Cells(size: 0.08)' 'Cells(size: 0.12)' 'Cells(size: 0.25)' 'Cells(size: 0.5)' 'Cells(size: 1.0)'
