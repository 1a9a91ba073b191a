#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Strangers' projects by every way to magimu, with two compilers and flags of their own; one line each.
#   consumers.sh BUILD SOURCE
set -euo pipefail
build=$1 source=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
cmake --install "$build" --prefix "$folder/usr" >/dev/null
pc=$(dirname "$(find "$folder/usr" -name magimu.pc)")

tell() {  # how, compiler, flags, status
  echo "$([ "$4" -eq 0 ] && echo ok || echo FAILED): $1, $2 $3"
  [ "$4" -eq 0 ] || { tail -n 20 "$folder/log" >&2; failed=1; }
}
run() {  # how, compiler, flags, cmake's arguments...
  local status=0
  rm -rf "$folder/build"
  { cmake -S "$source/tests/packaging/consumer" -B "$folder/build" -DCMAKE_CXX_COMPILER="$2" \
      -DCMAKE_CXX_FLAGS="$3" "${@:4}" && cmake --build "$folder/build" -j 2 --target consumer &&
      "$folder/build/consumer"; } >"$folder/log" 2>&1 || status=$?
  tell "$1" "$2" "$3" $status
}

# What this machine can run of these.
instructions=("" -O0 -march=native)
grep -q '\bavx2\b' /proc/cpuinfo 2>/dev/null && instructions+=(-mavx2)
for compiler in g++ clang++; do
  command -v $compiler >/dev/null || continue
  for flags in "${instructions[@]}"; do
    run find_package $compiler "$flags" -DCMAKE_PREFIX_PATH="$folder/usr"
    status=0
    # shellcheck disable=SC2046,SC2086
    { $compiler $flags -o "$folder/with_pc" "$source/tests/packaging/consumer/main.cpp" \
        $(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs magimu) && "$folder/with_pc"; } \
      >"$folder/log" 2>&1 || status=$?
    tell pkg-config $compiler "$flags" $status
  done
done
# The whole library under the user's flags, -Wall among them, which are no errors of the user's.
run add_subdirectory g++ "-march=native -Wall" -DMAGIMU_TAKEN=subdirectory -DMAGIMU_SOURCE="$source" \
  -DCMAKE_BUILD_TYPE=Release
run FetchContent clang++ -O1 -DMAGIMU_TAKEN=fetched -DMAGIMU_SOURCE="$source"
# Each public header by itself.
for header in $(cd "$folder/usr/include" && find magimu -name '*.h'); do
  status=0
  # shellcheck disable=SC2046
  echo "#include <$header>" | g++ -x c++ -fsyntax-only -Wall -Wextra -Werror \
    $(PKG_CONFIG_PATH=$pc pkg-config --cflags magimu) - >"$folder/log" 2>&1 || status=$?
  [ $status -eq 0 ] || tell "<$header> by itself" g++ "" $status
done
exit $failed
