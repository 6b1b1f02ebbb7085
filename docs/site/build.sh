#!/usr/bin/env bash
# Builds the documentation as a site with search, in target/site/html: `docs/site/build.sh`.
# It needs mdBook: cargo install mdbook --version 0.5.4 --locked
set -euo pipefail
cd "$(dirname "$0")/../.."
if ! command -v mdbook >/dev/null; then
  echo "mdbook is not there: cargo install mdbook --version 0.5.4 --locked" >&2
  exit 2
fi

site=${CARGO_TARGET_DIR:-target}/site
rm -rf "$site"
mkdir -p "$site/src/codes"
cp docs/site/book.toml docs/site/sgr.js "$site"
cp -r docs/*.md docs/*.png docs/calibration-example docs/bodies "$site/src"
cp ARCHITECTURE.md CONTRIBUTING.md CHANGELOG.md SECURITY.md "$site/src"
cp grammar-lang/src/diagnostics/catalogue/*.md "$site/src/codes"
# The README is the first page; the other pages lie beside it here.
sed 's|](docs/|](|g' README.md > "$site/src/README.md"
sed -i 's|](\.\./|](|g' "$site/src"/*.md
# The words behind `sgr` in the catalogue say which example it is.
sed -i -E 's/^```sgr (fails|mended)$/```sgr/; s/^```sgr [^ ]+\.sgr$/```sgr/' "$site/src"/*.md "$site/src/codes"/*.md

title() { sed -n 's/^# //p;T;q' "$1"; }
page() { echo "- [$(title "$site/src/$1")]($1)"; }
{
  echo "[sgc](README.md)"
  echo "# Learn"
  for page in tutorial tour cookbook bodies; do page "$page.md"; done
  echo "# Reference"
  for page in language search results studies usual cannot mistakes audit testing; do page "$page.md"; done
  echo "- [What findings mean]()"
  for file in "$site"/src/codes/*.md; do echo "  $(page "codes/$(basename "$file")")"; done
  echo "# Physics and hardware"
  for page in physics particles materials calibration hardware gaits novelty experiments; do page "$page.md"; done
  echo "# The project"
  for page in ARCHITECTURE CONTRIBUTING CHANGELOG SECURITY; do page "$page.md"; done
} > "$site/src/SUMMARY.md"

mdbook build "$site"
echo "open $site/html/index.html"
