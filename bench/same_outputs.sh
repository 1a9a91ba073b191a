#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# For changes that should change nothing: do two programs say the same of the same recordings, to the
# last bit? Texts and files of info, calibrate, diagnose, apply and stream, but for times and versions.
#   bench/same_outputs.sh OLD NEW RECORDING...       (for example build-old/magimu build/magimu *.csv)
# Without recordings 40 simulated ones are made. Exit code 1 if anything differs.
set -euo pipefail
old=$(realpath "$1") new=$(realpath "$2")
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
recordings=()
for recording in "$@"; do recordings+=("$(realpath "$recording")"); done
if [ ${#recordings[@]} -eq 0 ]; then
  effects=(none gyro_bias_drift mag_lag acc_scale_misalignment hard_iron_change)
  for k in $(seq 0 39); do
    arguments=(--seed $((7000 + k)) --rate $((25 * (1 + k % 4))) --duration $((40 + 10 * (k % 3))))
    [ $((k % 2)) -eq 0 ] && arguments+=(--motion hand) || arguments+=(--motion hand_held)
    effect=${effects[$((k / 2 % 5))]}
    [ "$effect" = none ] || arguments+=(--effect "$effect")
    "$old" simulate -q -o "$folder/$k.csv" "${arguments[@]}"
    recordings+=("$folder/$k.csv")
  done
fi

without_times() {
  sed -E 's/[0-9.]+ (s|ms)\b/_ s/g; s/"(seconds|iteration_seconds|version|date|compiler|command)": ?[^,}]*/"\1": _/g'
}
answers() {  # program, recording, folder
  mkdir -p "$3"
  local status
  for command in info "calibrate -o $3/cal.json" "diagnose -o $3/diagnosis.json" \
    "apply --calibration $3/cal.json -o $3/applied.csv" "stream -o $3/stream.json"; do
    # shellcheck disable=SC2086
    set -- "$1" "$2" "$3" $command
    status=0
    "$1" "$4" "$2" "${@:5}" >"$3/$4.out" 2>"$3/$4.err" </dev/null || status=$?
    echo "$status" >>"$3/$4.out"
  done
  for file in "$3"/*; do
    without_times <"$file" | sed "s#$3#FOLDER#g" >"$file.shown"
    rm "$file"
  done
}
different=0
for recording in "${recordings[@]}"; do
  rm -rf "$folder/old" "$folder/new"
  answers "$old" "$recording" "$folder/old"
  answers "$new" "$recording" "$folder/new"
  if ! diff -r "$folder/old" "$folder/new" >"$folder/diff"; then
    echo "different: $(basename "$recording")"
    head -n 6 "$folder/diff"
    different=$((different + 1))
  fi
done
echo "$different of ${#recordings[@]} recordings differ"
[ $different -eq 0 ]
