#!/usr/bin/env bash
# A study on Slurm, with two node daemons of this machine: workers are killed at random, and what is left is submitted again
# until all runs are complete. Then the results must be those of the study done here, bit for bit.
#
#   tests/study/slurm.sh STUDY.toml FOLDER [KILLS [RUNS PER TASK]]
#
# SGC is the program (default: sgc), SIGNALS what workers are killed with (default: KILL KILL TERM; after TERM Slurm lets a task wait for
# two minutes before it starts it again). It needs slurmctld, slurmd, munged and the rights of root.
set -euo pipefail
study=${1:?usage: slurm.sh STUDY.toml FOLDER [KILLS [RUNS PER TASK]]}
folder=$(mkdir -p "$2" && cd "$2" && pwd)
kills=${3:-4}
per_task=${4:-2}
sgc=${SGC:-sgc}
host=$(hostname -s)
grep -q "[[:space:]]$host\b" /etc/hosts || echo "127.0.0.1 $host" >>/etc/hosts

export SLURM_CONF=$folder/slurm.conf
mkdir -p "$folder/state" "$folder/one" "$folder/two" /run/munge
# A task that is queued again waits until its old credential has expired.
cat >"$SLURM_CONF" <<END
ClusterName=sgc
SlurmctldHost=$host
SlurmctldPort=17101
AuthType=auth/munge
AuthInfo=cred_expire=3
CryptoType=crypto/munge
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/%n
SlurmctldPidFile=$folder/state/pid
SlurmdPidFile=$folder/%n/pid
SlurmctldLogFile=$folder/state/log
SlurmdLogFile=$folder/%n/log
SlurmUser=root
ReturnToService=2
MpiDefault=none
KillWait=2
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=sched_interval=1,batch_sched_delay=1
NodeName=one NodeHostname=$host Port=17102 CPUs=2
NodeName=two NodeHostname=$host Port=17103 CPUs=2
PartitionName=all Nodes=one,two Default=YES State=UP
END
stop() {
  scancel --user="$(id -un)" 2>/dev/null || true
  for pid in "$folder"/{one,two,state}/pid; do
    if [ -e "$pid" ]; then kill "$(cat "$pid")" 2>/dev/null || true; fi
  done
}
trap stop EXIT
if ! munge -n >/dev/null 2>&1; then
  [ -e /etc/munge/munge.key ] || mungekey
  chown munge:munge /run/munge /var/log/munge /var/lib/munge
  runuser -u munge -- munged
fi
slurmctld
slurmd -N one
slurmd -N two

"$sgc" study "$study" --out "$folder/here" --quiet
"$sgc" study submit "$study" --out "$folder/there" --to slurm >/dev/null
for round in $(seq 1 40); do
  "$sgc" study submit "$folder/there" --to slurm --go --runs-per-task "$per_task" --minutes 30 --sgc "$(command -v "$sgc")"
  sleep 1
  while squeue --noheader | grep -q .; do
    sleep 0.5
    worker=$(pgrep -f "study work .*$folder/there" | xargs -r ps -o pid=,comm= -p | awk '$2 == "sgc" { print $1 }' | shuf -n 1 || true)
    if [ "$kills" -gt 0 ] && [ -n "$worker" ]; then
      # shellcheck disable=SC2086
      signal=$(printf '%s\n' ${SIGNALS:-KILL KILL TERM} | shuf -n 1)
      kill "-$signal" "$worker" 2>/dev/null && kills=$((kills - 1)) && echo "SIG$signal to a worker"
    fi
  done
  if [ "$("$sgc" study status "$folder/there" | wc -l)" = 2 ] && "$sgc" study status "$folder/there" | grep -q ^complete; then
    break
  fi
done
"$sgc" study status "$folder/there" | tee "$folder/status"
grep -q ^complete "$folder/status" && [ "$(wc -l <"$folder/status")" = 2 ]
(cd "$folder/here/runs" && find . -name best.design.json -o -name evals.csv -o -name result.json) | sort | while read -r file; do
  cmp "$folder/here/runs/$file" "$folder/there/runs/$file"
done
echo "the same bits after $round submissions"
