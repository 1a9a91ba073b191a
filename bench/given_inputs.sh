#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Inputs that once failed, each with the answer that is right: does the program give it?
#   bench/given_inputs.sh FOLDER [PROGRAM]     FOLDER has strangers/ and hostile/
# A line each: the exit code, and what the program says, must be what is written here. At most 6 GB of
# addresses each, and 120 s. Exit code 1 if an answer is another.
set -uo pipefail
given=$(realpath "$1") program=$(realpath "${2:-build/magimu}")
strangers=$given/strangers hostile=$given/hostile
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
failed=0 total=0

# Exit codes that are right (a|b), a pattern of what must be said (extended, "-" for nothing), arguments.
answers() {
  local codes=$1 pattern=$2 status=0
  shift 2
  (ulimit -v 6000000; timeout 120 "$program" "$@" >said 2>&1 </dev/null) || status=$?
  # What a file says is said, too.
  cat ./*.said.json >>said 2>/dev/null
  total=$((total + 1))
  local verdict=right
  [[ "|$codes|" == *"|$status|"* ]] || verdict="WRONG, exit $status"
  if [ "$pattern" != - ] && ! tr '\n' ' ' <said | tr -s ' ' | grep -qiE "$pattern"; then
    verdict="$verdict, WRONG: not said: $pattern"
  fi
  [ "$verdict" = right ] || { failed=$((failed + 1)); grep -v '^ *"' said | head -5; }
  printf '%-60s %s\n' "${*//$given\//}" "$verdict"
  rm -f ./*.said.json
}
made() { MAGIMU=$program "$strangers/make.sh" "$1" "$1.csv"; echo "$1.csv"; }

echo "Crashes"
answers '0|1|2' 'unit t=us|us since|microseconds' info "$strangers/epoch_us.csv"
answers '0|1' - calibrate "$strangers/epoch_us.csv"
answers '0|1' - diagnose "$strangers/epoch_us.csv"
for threads in 1 2; do
  answers 1 'short|turned|gap' calibrate "$strangers/crash_covariance.csv" --unit mag=gauss --threads $threads
done
answers 1 'short|turned|rows|samples' diagnose "$strangers/crash_diagnose.csv" --unit mag=mG
answers 0 'trust: *yes' calibrate "$(made mag_pair)"
answers '0|1|2' 'clip|largest|range' diagnose "$(made gyro_clipped)"
answers '0|1|2' 'inverted|mirror|sign|axes gyr=' diagnose "$(made gyro_z_inverted)"

echo "Wrong answers"
answers '1|2' 'same length|normali' calibrate "$(made mag_unit_vectors)"
answers '0|1' 'magnetometer.*(jump|current|change|departure|unexplained|none of)' diagnose "$(made current_unknown)"
answers '0|1' 'gyro-interval' diagnose "$(made decimated_20hz)"
answers 0 '100 Hz' info "$(made bursts)"
answers '0|1' '(reads|times).*2\.0|2\.0.*(times|reads)|twice|factor' info "$(made gyro_twice)"
answers '0|1|2' '2\.0+ times|twice|reads 2' calibrate gyro_twice.csv
answers '0|1|2' '2\.0+ times|twice|reads 2' diagnose gyro_twice.csv
answers '0|1' 'accelerometer' calibrate "$(made acc_gain)"
answers '0|1' 'accelerometer.*2(\.0)? ?%' diagnose acc_gain.csv
answers 0 'sentinel|impossible|overflow|set aside' info "$(made mag_sentinel)"
answers '0|1|2' 'counts' info "$(made counts_lis3mdl)" --unit mag=mG
answers '0|1|2' '0\.00174' info "$(made gyro_tenth_deg)" --unit gyr=deg/s
answers '0|1' '30(\.[0-9])? deg.*z|z.*30(\.[0-9])? deg' calibrate "$(made mounted_30deg)"
answers '0|1' '30(\.[0-9])? deg' info mounted_30deg.csv
answers '0|1|2' 'count.*rate|rate.*count' info "$strangers/sample_counter.csv"

echo "Not read"
answers '0|1' - info "$strangers/phyphox_folder"
answers '1|2' 'Acceleration' info "$strangers/phyphox_no_gravity"
for file in phyphox_decimal_comma decimal_comma.csv rows_of_one_time.csv repeated_rows.csv nan_token.csv \
  commented_header.csv numpy_savetxt.csv preamble.csv units_row.csv numbered_axes.csv spaces.txt \
  long_format.csv trailing_separator.csv cut_off.csv; do
  answers '0|1' - info "$strangers/$file"
done
answers '0|1' - info "$strangers/rostopic_imu.csv" "$strangers/rostopic_mag.csv"
answers '0|1' - info "$strangers/ulog2csv_sensor_combined_0.csv" "$strangers/ulog2csv_vehicle_magnetometer_0.csv"
answers '0|1' - info "$strangers/no_header.csv" --columns t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z
answers 2 'columns' info "$strangers/no_header.csv"
answers '0|1' - info "$strangers/key_value.txt" --rate 50
answers 2 'rate' info "$strangers/no_time.csv"
answers '0|1' - info "$strangers/no_time.csv" --rate 50

echo "Hostile"
(sh "$hostile/repeat_mag.sh" "$program" 3 5)
answers '0|1' - stream rep.csv -q -o rep.said.json
answers '0|1' - calibrate rep.csv
"$program" simulate -q -o g.csv --truth g.json --motion hand_held --rate 100 --seed 1 --effect gyro_scale_misalignment=0.3
answers '0|1' - calibrate g.csv -o g.said.json
answers 2 'unit mag=nT' stream "$hostile/mag_nT.csv" -o c.json
for glitch in acc_glitch_1e5 acc_glitch_1e16; do
  answers '0|1' - stream "$hostile/$glitch.csv" -q -o glitch.said.json
  answers '0|1' 'set aside' calibrate "$hostile/$glitch.csv"
done
answers '0|1|2' - info "$hostile/epoch_us_60.csv"
answers '0|1' - calibrate "$hostile/clock_jump_1day.csv"
answers 0 'set aside' calibrate "$hostile/mag_4900.csv"
answers '0|1' 'set aside' calibrate "$hostile/mag_1e20.csv"
answers '0|1' 'outliers' diagnose "$hostile/diagnose_outliers.csv"
answers '0|1|2' - calibrate "$hostile/base.csv" --noise 0.02 8.7e-4 1e-20
"$program" simulate -q -o b.csv --motion hand --rate 100 --duration 60 --seed 3
awk 'BEGIN{FS=OFS=","} NR==900{$2="1e20"} {print}' b.csv >b20.csv
answers 0 'set aside' calibrate b20.csv
answers 2 '\[|field|missing|must' export "$hostile/fields_empty.json" --to c
answers 2 - apply "$hostile/fields_empty.json" "$hostile/base.csv" -o x.csv
answers 2 - export "$hostile/strength_null.json" --to c
answers 2 - apply "$hostile/strength_negative.json" "$hostile/base.csv" -o x.csv
answers '0|1' - export "$hostile/escape_in_reason.json" --to c
mkfifo fifo
answers 2 - info "$hostile/external_link_to_fifo.h5"
cp b.csv own.csv
answers 2 'input' calibrate own.csv -o own.csv
answers 2 - calibrate own.csv -o ''
answers 2 - stream own.csv --state st -o st
echo "$((total - failed)) of $total are right"
[ "$failed" -eq 0 ]
