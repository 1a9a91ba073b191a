#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Objects that are compiled for an instruction set define nothing that other objects could share:
# of a function defined twice the linker keeps one, and it might be one that this machine cannot
# run. Every symbol that is not local must carry the name of the instruction set.
#   lane_symbols.sh ARCHIVE...
set -euo pipefail
objects=0 bad=0
for archive in "$@"; do
  for isa in baseline avx2 avx512; do
    for object in $(ar t "$archive" | grep "_${isa}\.cpp\.o\$"); do
      objects=$((objects + 1))
      folder=$(mktemp -d)
      (cd "$folder" && ar x "$archive" "$object")
      # Defined and not local: upper-case types, and u, v, w.
      shared=$(nm --defined-only "$folder/$object" | awk '$2 ~ /^[A-Zuvw]$/ {print $3}' |
        grep -v "N6magimu${#isa}${isa}" || true)
      rm -r "$folder"
      if [ -n "$shared" ]; then
        echo "$object shares:" && c++filt <<<"$shared"
        bad=1
      fi
    done
  done
done
echo "$objects objects"
[ "$objects" -ge 2 ] && [ "$bad" -eq 0 ]
