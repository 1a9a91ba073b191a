#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A new user's trial on bare Debian roots, which debootstrap makes: the README's first command and
# the packages in one root with nothing but git, the packages in a second root without a compiler, a
# stranger's project there, and the Python module. One line a step; what each said is in FOLDER/*.log.
# As root:
#   packaging/bare_root.sh FOLDER [SUITE [MIRROR]]     (bookworm; some 40 minutes of a processor)
# TRIAL="roots demo package use consumer python" chooses steps; "test" is the README's second command.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '3,8s/^# //p' "$0" >&2; exit 2; }
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mkdir -p "$1"
folder=$(cd "$1" && pwd) suite=${2:-bookworm} mirror=${3:-http://deb.debian.org/debian}
trial=${TRIAL:-roots demo package use consumer python}
# Mounts end with the script.
[ "${BARE_ROOT_MOUNTS:-}" ] || BARE_ROOT_MOUNTS=own exec unshare -m "$0" "$folder" "$suite" "$mirror"

enter() {  # root, command: as a new user's shell has it, with none of this machine's variables
  env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb \
    LANG=C.UTF-8 nice -n 10 chroot "$folder/$1" bash -euc "cd /root && $2" </dev/null
}
step() {  # name, what it is, root, command
  [[ " $trial " == *" ${1%%_*} "* ]] || return 0
  local status=0 began=$SECONDS
  enter "$3" "$4" >"$folder/$1.log" 2>&1 || status=$?
  echo "$([ $status -eq 0 ] && echo ok || echo "FAILED ($status)"): $2 ($((SECONDS - began)) s)"
  [ $status -eq 0 ] || { tail -n 20 "$folder/$1.log" >&2; exit 1; }
}

if [[ " $trial " == *" roots "* ]]; then
  command -v debootstrap >/dev/null || { echo "Please install debootstrap." >&2; exit 2; }
  rm -rf "$folder/bare" "$folder/first" "$folder/second"
  debootstrap --variant=minbase "$suite" "$folder/bare" "$mirror" >"$folder/roots.log" 2>&1
  cp /etc/resolv.conf /etc/hosts "$folder/bare/etc/"
  cp -a "$folder/bare" "$folder/first"
  mv "$folder/bare" "$folder/second"
  git clone -q --bare "$source" "$folder/first/root/magimu.git"
fi
for root in first second; do mount -t proc proc "$folder/$root/proc"; done

install="DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends"
step roots_git "git and the project's clone" first \
  "apt-get update && $install git ca-certificates && git clone /root/magimu.git magimu"
step demo "./dev demo" first "cd magimu && ./dev demo"
step test "./dev test" first "cd magimu && ./dev test"
step package "./dev package" first "cd magimu && ./dev package && mkdir -p ../debs && mv build/*.deb ../debs"
cp -r "$folder/first/root/debs" "$folder/first/root/magimu/docs/tutorial" \
  "$folder/first/root/magimu/tests/packaging/consumer" "$folder/second/root/" 2>/dev/null || true
step use_install "the program's package in the second root" second \
  "apt-get update && $install ./debs/magimu_*.deb && ! command -v g++ cmake"
step use_program "magimu info, calibrate, apply, export on the tutorial's recording" second \
  "magimu --version && magimu info tutorial/hand_rotation.csv &&
   magimu calibrate tutorial/hand_rotation.csv -o cal.json --report cal.html &&
   magimu apply cal.json tutorial/hand_rotation.csv -o corrected.csv &&
   magimu export cal.json --to px4 -o cal.params && test -s cal.html -a -s cal.params"
step use_manual "its manual" second "$install man-db && man magimu | grep -q -- --threads"
step consumer_install "the development package" second \
  "$install ./debs/libmagimu-dev_*.deb g++ cmake make pkg-config"
step consumer_cmake "a stranger's project, find_package" second \
  "cmake -S consumer -B with_cmake && cmake --build with_cmake --target consumer && with_cmake/consumer"
step consumer_pc "a stranger's project, pkg-config" second \
  'g++ -o with_pc consumer/main.cpp $(pkg-config --cflags --libs magimu) && ./with_pc'
step python_install "pip install --no-build-isolation ." first \
  "cd magimu && ./dev setup && python3 -m venv --system-site-packages ~/venv && . ~/venv/bin/activate &&
   pip install --no-build-isolation ."
step python_example "the README's example in Python" first \
  "sed -n '/^    import magimu/,/^    calibration.save/s/^    //p' magimu/README.md >example.py &&
   . ~/venv/bin/activate && cd magimu/docs/tutorial && python ~/example.py"
