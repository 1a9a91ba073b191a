#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# A simulated fleet through `magimu reprocess`: kill -9 again and again, a disk that is full once,
# broken files; then each file must have a result or a reason, none lost, none twice, and a second run
# must do nothing. Usage: archive_fleet.sh MAGIMU [DEVICES RECORDINGS BROKEN]
set -eu
magimu=$(realpath "$1") devices=${2:-4} recordings=${3:-5} broken=${4:-6}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir in
echo "path,device,place,date,options" >manifest.csv
n=0
for d in $(seq "$devices"); do
  for r in $(seq "$recordings"); do
    n=$((n + 1))
    name=in/b$d-$r.csv day=$(date -d "2024-01-01 + $r days" +%F) options=""
    "$magimu" simulate -o "$name" --motion hand --rate 20 --duration 60 \
      --device "$d" --seed $((100 * d + r)) -q
    case $((n % 6)) in # as other loggers write them
      1) awk -F, -v OFS=, 'NR == 1 { print; next } { for (i = 5; i <= 7; ++i) $i *= 57.29577951; print }' \
           "$name" >t && mv t "$name"; options="--unit gyr=deg/s" ;;
      2) tr , ';' <"$name" >t && mv t "$name" ;;
      3) tr , '\t' <"$name" >t && mv t "$name" ;;
      4) gzip "$name" && name=$name.gz ;;
      5) /usr/bin/python3 - "$name" <<'PY' && rm "$name" && name=${name%.csv}.npz ;;
import numpy, sys
rows = numpy.genfromtxt(sys.argv[1], delimiter=",", names=True)
def of(sensor): return numpy.column_stack([rows[f"{sensor}_{axis}"] for axis in "xyz"])
numpy.savez(sys.argv[1][:-4], t=rows["t"], acc=of("acc"), gyr=of("gyr"), mag=of("mag"))
PY
    esac
    echo "$name,b$d,lab,$day,$options" >>manifest.csv
  done
done
for b in $(seq "$broken"); do
  case $((b % 5)) in
    0) head -c 3000 in/b1-1.csv >"in/x-$b.csv" ;;              # cut off
    1) : >"in/x-$b.csv" ;;                                     # empty
    2) head -c 20000 /dev/urandom >"in/x-$b.csv" ;;            # noise
    3) sed 's/,[^,]*$//' in/b1-1.csv >"in/x-$b.csv" ;;         # a column lost
    4) echo "not there" >/dev/null ;;                          # missing
  esac
  echo "in/x-$b.csv,x,lab,2024-01-01," >>manifest.csv
done
begin=$(date +%s.%N)
# A disk that is full: no file may grow beyond 8 kB.
(ulimit -f 16; "$magimu" reprocess manifest.csv -o out -q -j 2 2>full.txt) && echo "FAILED: full disk" || true
cat full.txt
# Killed, ten times.
for k in $(seq 10); do
  "$magimu" reprocess manifest.csv -o out -q -j 2 2>/dev/null &
  sleep "1.$k"
  kill -9 $! 2>/dev/null || true
  wait $! 2>/dev/null || true
done
"$magimu" reprocess manifest.csv -o out -j 2
end=$(date +%s.%N)
echo "all: $(echo "$end - $begin" | bc) s"
begin=$(date +%s.%N)
"$magimu" reprocess manifest.csv -o out -j 2
echo "again: $(echo "$(date +%s.%N) - $begin" | bc) s"
python3 - "$n" "$broken" <<'PY'
import csv, os, sys
rows = list(csv.DictReader(open("out/recordings.csv")))
good = [r for r in rows if r["status"] == "calibrated"]
bad = [r for r in rows if r["status"] != "calibrated"]
results = {f[:-5] for f in os.listdir("out/results") if f.endswith(".json")}
print(f"{len(good)} results, {len(bad)} refusals; wanted {sys.argv[1]} and {sys.argv[2]}")
ok = len(good) == int(sys.argv[1]) and len(bad) == int(sys.argv[2])
ok &= all(r["reason"] and r["remedy"] for r in bad)
ok &= len({r["path"] for r in rows}) == len(rows) and {r["result"] for r in rows if r["result"]} == results
sys.exit(0 if ok else "FAILED")
PY
