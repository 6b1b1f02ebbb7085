#!/usr/bin/env bash
# Optimised (body, gait) pairs to compare simulators on: short searches for gaits of the three
# bodies of benches/bodies/, and for bodies with gaits by grammars/experiments/codesign_thesis.sgr.
#
#   benches/peers/gaits.sh FOLDER [SEEDS] [EVALUATIONS]
#
# SGC is the program (default: sgc). What is there already is kept, so it can be stopped and gone on with.
set -euo pipefail
folder=${1:?usage: gaits.sh FOLDER [SEEDS] [EVALUATIONS]}
seeds=${2:-8}
evaluations=${3:-600}
sgc=${SGC:-sgc}
here=$(cd "$(dirname "$0")/../.." && pwd)

search() { # folder, then what `sgc run` takes
  [ -e "$1/result.json" ] && return
  "$sgc" run "${@:2}" --max-evals "$evaluations" --jobs 1 --quiet --force --out "$1" >/dev/null
}

mkdir -p "$folder"
for seed in $(seq "$seeds"); do
  for body in two four eight; do
    search "$folder/$body-$seed" "$here/benches/bodies/bodies.sgr" --from "$body" --seed "$seed"
  done
  search "$folder/codesign-$seed" "$here/grammars/experiments/codesign_thesis.sgr" --seed "$seed"
done
