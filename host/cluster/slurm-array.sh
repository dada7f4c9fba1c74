#!/bin/bash
# Shoots a job in parts, one for each task of a Slurm array:
#
#   sbatch --array=0-99 slurm-array.sh 100 10000000000 parts  shoot city.obj --photons 10000000000
#
# PARTS is the number of parts, ALL that of all photons (--photons, times --passes of a picture), FOLDER where the parts
# go; then the command of arboleda. Task i shoots part i. A task that was killed goes on from its checkpoint, and one
# whose part is there does nothing: send what failed again with --array=3,7, or all of it.
#
#SBATCH --job-name=arboleda
#SBATCH --ntasks=1
#SBATCH --requeue
set -euo pipefail

usage="usage: sbatch --array=0-LAST slurm-array.sh PARTS ALL FOLDER COMMAND.."
(($# >= 4)) || { echo "$usage" >&2; exit 2; }
parts=$1 all=$2 folder=$3
shift 3
# The product of both is below 2^63.
[[ $parts =~ ^[1-9][0-9]{0,5}$ ]] || { echo "PARTS is $parts; it must be a number below 10^6; $usage" >&2; exit 2; }
[[ $all =~ ^[1-9][0-9]{0,11}$ ]] || { echo "ALL is $all; it must be a number below 10^12; $usage" >&2; exit 2; }
task=${SLURM_ARRAY_TASK_ID:?this script is a task of an array: sbatch --array=0-$((parts - 1))}
((task < parts)) || { echo "task $task of $parts parts: give --array=0-$((parts - 1))" >&2; exit 2; }
arboleda=${ARBOLEDA:-arboleda}

start=$((task * all / parts)) end=$(((task + 1) * all / parts))
((start < end)) || exit 0
mkdir -p "$folder"
# Parts that are there count only if they are of this job, cut alike. The first task writes what that is.
job=$(printf '%q ' "$parts" "$all" "$@")
if [[ ! -e $folder/job ]]; then
    own=$(mktemp "$folder/job.XXXXXX")
    echo "$job" >"$own"
    ln "$own" "$folder/job" 2>/dev/null || true
    rm -f "$own"
fi
[[ $(<"$folder/job") == "$job" ]] || {
    echo "$folder has parts of another job: $(<"$folder/job"); give another folder" >&2
    exit 2
}
name=$(printf '%s/%07d' "$folder" "$task")
if [[ -e $name.part ]]; then
    echo "$name.part is there"
    exit 0
fi
threads=()
[[ -z ${SLURM_CPUS_PER_TASK:-} ]] || threads=(--threads "$SLURM_CPUS_PER_TASK")
"$arboleda" "$@" "${threads[@]}" --photon-range "$start..$end" --part "$name.part" \
    --checkpoint "$name.checkpoint" --checkpoint-every "${CHECKPOINT_EVERY:-300}"
rm -f "$name.checkpoint"
