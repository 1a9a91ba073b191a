#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the built tree BUILD into a temporary folder and uses it as a stranger would: the program,
# its completion, find_package, pkg-config, and the .deb. Usage: install_test.sh BUILD SOURCE
set -eu
build=$1 source=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }

cmake --install "$build" --prefix "$folder/usr" >"$folder/log" || fail "install: $(cat "$folder/log")"
magimu=$folder/usr/bin/magimu

version=$("$magimu" --version)
for fact in 'magimu [0-9]' 'compiler: ' 'build type: ' 'SuiteSparse: \(yes\|no\)'; do
  grep -q "$fact" <<<"$version" || fail "--version lacks $fact"
done

# Completion offers every subcommand of the help, and the options of each.
completion=$folder/usr/share/bash-completion/completions/magimu
complete_words() { # the words typed so far -> what is offered
  bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _magimu
           printf "%s\n" "${COMPREPLY[@]}"' - "$completion" "$@"
}
commands=$("$magimu" --help | sed -n '/^Subcommands:/,/^$/p' | sed -n 's/^  \([a-z]*\) .*/\1/p')
test "$(wc -w <<<"$commands")" -ge 5 || fail "no subcommands in the help"
offered=$(complete_words magimu "")
for command in $commands; do
  grep -qx "$command" <<<"$offered" || fail "completion does not offer $command"
done
grep -qx -- --mag-time-offset <<<"$(complete_words magimu calibrate --mag)" || fail "no options"
grep -qx ardupilot <<<"$(complete_words magimu export --to "")" || fail "no values of an option"

# The manual names every command and option, and man can read it.
manual=$(gzip -dc "$folder/usr/share/man/man1/magimu.1.gz")
for word in "magimu calibrate" "magimu stream" '\\-\\-mag\\-time\\-offset' '\\-\\-page'; do
  grep -q -- "$word" <<<"$manual" || fail "the manual lacks $word"
done

# Under a user's own flags, too: what lies in memory must not depend on them.
for flags in "" "-O0" "-march=native"; do
  cmake -S "$source/tests/packaging/consumer" -B "$folder/build" -DCMAKE_CXX_FLAGS="$flags" \
    -DCMAKE_PREFIX_PATH="$folder/usr" >"$folder/log" 2>&1 || fail "find_package: $(cat "$folder/log")"
  cmake --build "$folder/build" >"$folder/log" 2>&1 || fail "find_package: $(cat "$folder/log")"
  "$folder/build/consumer" || fail "the program built with find_package and '$flags'"
done

# Taken in as sources it can be configured (consumers.sh builds it, which takes long).
for way in subdirectory fetched; do
  cmake -S "$source/tests/packaging/consumer" -B "$folder/$way" -DMAGIMU_TAKEN=$way \
    -DMAGIMU_SOURCE="$source" >"$folder/log" 2>&1 || fail "$way: $(cat "$folder/log")"
done

if command -v pkg-config >/dev/null; then
  pc=$(dirname "$(find "$folder/usr" -name magimu.pc)")
  flags=$(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs magimu) || fail "pkg-config"
  # shellcheck disable=SC2086
  c++ -o "$folder/with_pc" "$source/tests/packaging/consumer/main.cpp" $flags || fail "pkg-config"
  "$folder/with_pc" || fail "the program built with pkg-config"
fi

# Nothing but the public headers and what they need; none by another name than magimu/...
[ "$(find "$folder/usr/include" -mindepth 1 -maxdepth 1)" = "$folder/usr/include/magimu" ] ||
  fail "headers beside include/magimu"
[ "$(find "$folder/usr/include" -name '*.h' | wc -l)" -lt 100 ] || fail "too many headers"

if command -v dpkg-deb >/dev/null && command -v dpkg-shlibdeps >/dev/null; then
  (cd "$build" && cpack -G DEB -B "$folder/deb") >"$folder/log" 2>&1 || fail "$(cat "$folder/log")"
  program=$(dpkg-deb -c "$folder"/deb/magimu_*.deb)
  for file in usr/bin/magimu bash-completion/completions/magimu man/man1/magimu.1.gz \
    doc/magimu/copyright; do
    grep -q "$file" <<<"$program" || fail "the program's .deb lacks $file"
  done
  grep -q '\.h$' <<<"$program" && fail "the program's .deb has headers"
  dpkg-deb -f "$folder"/deb/magimu_*.deb Depends | grep -q libhdf5 ||
    fail "the program's .deb does not name what it needs"
  library=$(dpkg-deb -c "$folder"/deb/libmagimu-dev_*.deb)
  for file in magimuConfig.cmake magimu.pc magimu/calibration/calibrate.h libmagimu_graph.a; do
    grep -q "$file" <<<"$library" || fail "the library's .deb lacks $file"
  done
  grep -q usr/bin <<<"$library" && fail "the library's .deb has the program"
  dpkg-deb -f "$folder"/deb/libmagimu-dev_*.deb Depends | grep -q libeigen3-dev ||
    fail "the library's .deb does not name what it needs"
  file=$folder/deb/magimu_*.deb
  dpkg-deb -x $file "$folder/unpacked"
  "$folder/unpacked/usr/bin/magimu" --version >/dev/null || fail "the packed program"
fi
echo "installed, used by find_package and pkg-config, packed"
