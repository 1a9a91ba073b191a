#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The documentation as a site of plain pages: README, CONTRIBUTING, CHANGELOG and docs/*.md by
# pandoc, the manual page from the
# program where it is built, the library's interface by doxygen where that is installed. Every link
# between the pages is checked. Usage: make.sh FOLDER
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "$1"
out=$(cd "$1" && pwd)
cp docs/site/style.css "$out/"
cp -r docs/pictures docs/tutorial "$out/"

pages=(README tutorial howto python formats effects theory design thresholds evidence real_data windows
  reprocess study questions
  CONTRIBUTING CHANGELOG)
declare -A titles=([README]=Overview [tutorial]=Tutorial [howto]=How-tos [python]=Python
  [formats]=Files [effects]=Effects [theory]=Theory [design]=Design [thresholds]="Numbers that decide"
  [evidence]="What is missing" [real_data]="Real recordings" [windows]="How it is fast"
  [questions]=Questions [reprocess]=Archives [study]="The paper repeated"
  [CONTRIBUTING]=Contributing [CHANGELOG]=Changes)
for file in docs/*.md; do  # pages that are new come last
  name=$(basename "$file" .md)
  [ -n "${titles[$name]:-}" ] && continue
  pages+=("$name")
  titles[$name]=$(sed -n 's/^# //p' "$file" | head -n 1)
done
file_of() { [ "$1" = README ] && echo index.html || echo "$1.html"; }

navigation() {
  echo '<nav><b>magimu</b>'
  for page in "${pages[@]}"; do echo "<a href=\"$(file_of "$page")\">${titles[$page]}</a>"; done
  [ -f "$out/manual.html" ] && echo '<a href="manual.html">Manual page</a>'
  [ -d "$out/api" ] && echo '<a href="api/index.html">API</a>'
  echo '</nav>'
}

if command -v doxygen >/dev/null; then
  doxygen - <<END >"$out/doxygen.log" 2>&1
PROJECT_NAME = magimu
INPUT = statistics graph factors solvers recording earth sim calibration diagnosis
FILE_PATTERNS = *.h
RECURSIVE = YES
EXTRACT_ALL = YES
GENERATE_LATEX = NO
HAVE_DOT = NO
QUIET = YES
OUTPUT_DIRECTORY = $out
HTML_OUTPUT = api
INPUT_FILTER = "sed -E 's|^( *)// |\\1/// |'"
END
fi
if [ -x build/magimu ]; then
  build/magimu man >"$out/magimu.1"
  touch "$out/manual.html"
fi
navigation >"$out/nav.html"
convert() {  # format, source, target, title
  pandoc --standalone --toc --toc-depth=2 -f "$1" -t html5 --metadata pagetitle="magimu: $4" \
    --css style.css --include-before-body "$out/nav.html" "$2" |
    sed -E 's#href="(docs/|\.\./)?([A-Za-z_0-9]+)\.md(\#[^"]*)?"#href="\2.html\3"#g;
      s#href="README\.html#href="index.html#g; s#src="docs/pictures/#src="pictures/#g' >"$out/$3"
}
for page in "${pages[@]}"; do
  source=docs/$page.md
  [ -f "$source" ] || source=$page.md
  convert gfm "$source" "$(file_of "$page")" "${titles[$page]}"
done
[ -f "$out/magimu.1" ] && convert man "$out/magimu.1" manual.html "manual page"
rm "$out/nav.html"

# Every link to a file of this site leads somewhere.
broken=0
for page in "$out"/*.html; do
  while read -r target; do
    [ -e "$out/$target" ] && continue
    echo "$(basename "$page"): $target is not there" >&2
    broken=1
  done < <(grep -oE '(href|src)="[^"#]+' "$page" | sed -E 's/^[a-z]+="//' |
    grep -v '^[a-z]*:' | sort -u)
done
[ "$broken" -eq 0 ] || exit 1
echo "$out/index.html"
