#!/bin/sh
# Makes three.min.js again from the pinned packages; needs node, npm and the network.
# Usage: sh bundle.sh, in this folder. The result must have the sha256 that README.md records.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$here/entry.js" "$work/"
cd "$work"
npm init --yes >/dev/null
npm install --save-exact --ignore-scripts three@0.187.0 esbuild@0.28.2 >/dev/null
npx esbuild entry.js --bundle --minify --format=iife --global-name=THREE --target=es2020 \
  --legal-comments=none --outfile=bundle.js
cp node_modules/three/LICENSE "$here/LICENSE"
{
  printf '/*! three.js 0.187.0\n\n'
  cat node_modules/three/LICENSE
  printf '*/\n'
  cat bundle.js
} >"$here/three.min.js"
sha256sum "$here/three.min.js"
