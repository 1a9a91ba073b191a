#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# An archive on a Slurm cluster: a job array of magimu reprocess, and the merge when it is done.
#
#   packaging/slurm/submit.sh ARCHIVE OUT TASKS [sbatch options, such as --partition=short]
#
# ARCHIVE: a folder or a manifest; OUT: a folder that all nodes share. Run it again after losses: what
# has a result is not done again. MAGIMU names the program where it is not in PATH.
set -euo pipefail
if [ $# -lt 3 ]; then
  sed -n '3,9p' "$0" | sed 's/^# \{0,1\}//' >&2
  exit 2
fi
archive=$(realpath "$1") tasks=$3
mkdir -p "$2/log"
out=$(realpath "$2")
shift 3
here=$(dirname "$(realpath "$0")")
export MAGIMU=${MAGIMU:-magimu}
array=$(sbatch --parsable --array="1-$tasks" --output="$out/log/task-%a.txt" --requeue "$@" \
               "$here/task.sbatch" "$archive" "$out" "$tasks")
# afterany: lost tasks are rows of the tables, not a reason to have none.
merge=$(sbatch --parsable --dependency="afterany:${array%%;*}" --output="$out/log/merge.txt" "$@" \
               "$here/merge.sbatch" "$archive" "$out")
echo "array ${array%%;*} of $tasks tasks, merge ${merge%%;*}; logs in $out/log"
