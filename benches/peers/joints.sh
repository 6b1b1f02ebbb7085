#!/usr/bin/env bash
# Ten designs whose joints bend, twist, slide, spin and hang, for joints.py.
#
#   benches/peers/joints.sh FOLDER
#
# SGC is the program (default: sgc). What is there already is kept.
set -euo pipefail
folder=${1:?usage: joints.sh FOLDER}
sgc=${SGC:-sgc}
here=$(cd "$(dirname "$0")/../.." && pwd)

mkdir -p "$folder"
while read -r grammar seed; do
  out="$folder/$(basename "$grammar" .sgr)-$seed"
  [ -e "$out/result.json" ] && continue
  "$sgc" run "$here/$grammar" --max-evals 400 --seed "$seed" --quiet --force --out "$out" >/dev/null
done <<'LIST'
grammars/turtle.sgr 11
grammars/turtle.sgr 12
grammars/turtle.sgr 13
grammars/rover.sgr 11
grammars/rover.sgr 12
grammars/salamander.sgr 11
grammars/salamander.sgr 12
grammars/walker.sgr 11
benches/bodies/mixed.sgr 11
benches/bodies/mixed.sgr 12
LIST
