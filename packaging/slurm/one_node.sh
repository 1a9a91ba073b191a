#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# Slurm on this machine alone, without systemd and munge, as an ordinary user: to try a job array
# before a cluster sees it.
#
#   packaging/slurm/one_node.sh start FOLDER    prints what to export: SLURM_CONF
#   packaging/slurm/one_node.sh stop FOLDER
set -euo pipefail
if [ $# -ne 2 ]; then
  sed -n '3,8p' "$0" | sed 's/^# \{0,1\}//' >&2
  exit 2
fi
folder=$(realpath -m "$2")
conf=$folder/slurm.conf

start() {
  for program in slurmctld slurmd sinfo; do
    command -v "$program" >/dev/null || { echo "$program is not installed (Debian: slurm-wlm)" >&2; exit 2; }
  done
  mkdir -p "$folder"/{state,spool,log}
  local host user port
  host=$(hostname -s) user=$(id -un) port=$((20000 + $$ % 20000))
  cat >"$conf" <<CONF
ClusterName=magimu
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/slurmd.log
SlurmctldPort=$port
SlurmdPort=$((port + 1))
ReturnToService=2
MinJobAge=3600
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  SLURM_CONF=$conf slurmctld -f "$conf" -c >"$folder/log/start.txt" 2>&1
  SLURM_CONF=$conf slurmd -f "$conf" -N "$host" >>"$folder/log/start.txt" 2>&1
  for _ in $(seq 60); do
    if SLURM_CONF=$conf sinfo -h -o %T 2>/dev/null | grep -q idle; then
      echo "export SLURM_CONF=$conf"
      return
    fi
    sleep 0.5
  done
  echo "Slurm does not start; see $folder/log" >&2
  stop
  exit 1
}

# Only what this folder's own files name.
stop() {
  for daemon in slurmd slurmctld; do
    [ -s "$folder/$daemon.pid" ] && kill "$(cat "$folder/$daemon.pid")" 2>/dev/null || true
  done
}

case $1 in
  start) start ;;
  stop) stop ;;
  *) echo "start or stop" >&2; exit 2 ;;
esac
