#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# A job array of `magimu reprocess` on a Slurm of this machine alone gives the same tables as one run
# without it; so does GNU parallel. Usage: slurm_test.sh MAGIMU SOURCE. Exit code 77: not installed.
set -u
magimu=$1 source=$2
folder=$(mktemp -d)
node=$source/packaging/slurm/one_node.sh
trap '"$node" stop "$folder/slurm"; rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }

mkdir "$folder/in"
for seed in 1 2 3 4; do
  "$magimu" simulate -o "$folder/in/b1-$seed.csv" --motion hand --rate 20 --duration 40 --seed "$seed" -q \
    || fail simulate
done
"$magimu" reprocess "$folder/in" -o "$folder/alone" -q -j 2 || fail "alone"
tried=0

if command -v parallel >/dev/null && parallel --version 2>/dev/null | grep -q GNU; then
  tried=1
  parallel "$magimu" reprocess "$folder/in" -o "$folder/parallel" --shard {}/3 -j 1 -q ::: 1 2 3 \
    || fail "GNU parallel"
  "$magimu" reprocess "$folder/in" -o "$folder/parallel" --merge -q || fail "merge"
  cmp "$folder/alone/recordings.csv" "$folder/parallel/recordings.csv" || fail "parallel's tables"
  cmp "$folder/alone/devices/b1.json" "$folder/parallel/devices/b1.json" || fail "parallel's device"
else
  echo "skipped: GNU parallel is not installed"
fi

if command -v slurmctld >/dev/null && command -v slurmd >/dev/null; then
  tried=1
  started=$("$node" start "$folder/slurm") || fail "Slurm does not start: $(tail -5 "$folder"/slurm/log/*)"
  eval "$started"
  MAGIMU=$magimu "$source/packaging/slurm/submit.sh" "$folder/in" "$folder/slurm_out" 3 || fail submit
  for _ in $(seq 240); do
    [ -s "$folder/slurm_out/recordings.csv" ] && [ -z "$(squeue -h)" ] && break
    sleep 0.5
  done
  cmp "$folder/alone/recordings.csv" "$folder/slurm_out/recordings.csv" \
    || fail "Slurm's tables; logs: $(cat "$folder"/slurm_out/log/*)"
  cmp "$folder/alone/devices/b1.json" "$folder/slurm_out/devices/b1.json" || fail "Slurm's device"
else
  echo "skipped: slurm-wlm is not installed"
fi
[ "$tried" = 1 ] || exit 77
echo done
