#!/bin/bash
# Checks on one machine that a job has the same bytes in one process, with 1 to 4 ranks, killed and resumed, as an array
# of Slurm's, and with Dask:
#
#   check.sh ARBOLEDA [ranks|array|dask ..]
#
# ARBOLEDA was built with the feature `mpi`. The scene is that of tests/targets/light.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
arboleda=$(realpath "$1")
shift
(($# > 0)) || set -- ranks array dask
# Ranks share the processors of this machine, and may be root's.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
    OMPI_MCA_btl_base_warn_component_unused=0
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$here"/../../tests/targets/light/* "$folder"
cd "$folder"

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

# quiet COMMAND..: shows what a command says only if it fails.
quiet() {
    "$@" >log 2>&1 </dev/null || {
        cat log
        fail "$*"
    }
}

# refused TEXT COMMAND..: the command fails and says so.
refused() {
    local text=$1
    shift
    ! "$@" >log 2>&1 </dev/null || fail "not refused: $*"
    grep -q "$text" log || {
        cat log
        fail "does not say '$text': $*"
    }
}

same() {
    cmp "$1" "$2" || fail "$1 is not $2"
}

# The jobs: a name, the number of all photons, the ending and the option of the file that is compared, and the command.
jobs_of() {
    cat <<'JOBS'
shoot 3000000 npy --out|shoot room.obj --up z --photons 3000000
detp 20000 npy --out|irradiance room.obj --up z --photons 20000 --points points.npy
map 20000 npy --out|irradiance room.obj --up z --photons 20000 --points points.npy --estimator photon-map
picture 20000 pfm --out x.png --values|render room.obj --up z --photons 10000 --passes 2 --size 64 64
gathered 20000 pfm --out x.png --values|render room.obj --photons 20000 --size 64 64 --estimator photon-map --final-gather 4
JOBS
}

# each_job FUNCTION: calls it with the name, the photons, the file's ending, the option and the command of each job.
each_job() {
    local job command name all ending option words
    while IFS='|' read -r job command; do
        read -r name all ending option <<<"$job"
        read -ra words <<<"$command"
        "$1" "$name" "$all" "$ending" "$option" "${words[@]}"
    done < <(jobs_of)
}

whole() {
    local name=$1 ending=$3 option=$4
    # shellcheck disable=SC2086 # the option may be several words
    quiet "$arboleda" "${@:5}" $option "whole-$name.$ending"
}

# --- Ranks ---

ranks() {
    each_job on_ranks
    packed
    killed
    full
}

on_ranks() {
    local name=$1 ending=$3 option=$4 ranks
    for ranks in 1 2 3 4; do
        # shellcheck disable=SC2086
        quiet mpirun -n "$ranks" "$arboleda" "${@:5}" --threads 1 $option "ranks.$ending"
        same "ranks.$ending" "whole-$name.$ending"
    done
    echo "$name: 1 to 4 ranks"
}

# Ranks share a packed scene, and are bound as mpirun likes. Ranks of different jobs do not shoot together.
packed() {
    quiet "$arboleda" pack room.obj -o room.arb
    mv room.obj away.obj
    each_job on_packed
    mv away.obj room.obj
    refused "rank 1 has another job than rank 0: it has 2 as seed, not 1" \
        mpirun -n 1 "$arboleda" shoot room.obj --photons 5000 : -n 1 "$arboleda" shoot room.obj --photons 5000 --seed 2
}

on_packed() {
    local name=$1 ending=$3 option=$4 words=("${@:5}")
    [[ $name == shoot || $name == detp || $name == picture ]] || return 0
    # shellcheck disable=SC2086
    quiet mpirun -n 2 "$arboleda" "${words[@]/#room.obj/--index-file=room.arb}" $option "packed.$ending"
    same "packed.$ending" "whole-$name.$ending"
    echo "$name: 2 ranks, a packed scene"
}

# A rank is killed after the first checkpoint, twice. The job goes on with another number of ranks.
killed() {
    local command=(shoot room.obj --up z --photons 20000000 --index wide-bvh)
    quiet "$arboleda" "${command[@]}" --out whole.npy
    command+=(--threads 1)
    local with=(--checkpoint job.checkpoint --checkpoint-every 0.3 --out job.npy) count job rank before
    for count in 4 3; do
        before=$(stat -c %Y.%s.%i job.checkpoint 2>/dev/null || true)
        mpirun -n "$count" "$arboleda" "${command[@]}" "${with[@]}" >log 2>&1 </dev/null &
        job=$!
        until [[ $(stat -c %Y.%s.%i job.checkpoint 2>/dev/null || true) != "$before" ]]; do
            kill -0 "$job" 2>/dev/null || fail "the job ended before its checkpoint: $(cat log)"
            sleep 0.05
        done
        rank=$(pgrep -P "$job" | tail -1)
        kill -9 "$rank"
        ! wait "$job" || fail "the job did not notice that a rank was killed"
        [[ ! -e job.npy ]] || fail "a killed job wrote its result"
        "$arboleda" merge job.checkpoint --missing >missing
        [[ $(wc -l <missing) == 1 ]] || fail "the checkpoint is not one range: $(cat missing)"
        echo "killed with $count ranks; to be shot: $(cat missing)"
    done
    quiet mpirun -n 2 "$arboleda" "${command[@]}" "${with[@]}"
    grep -q "goes on from job.checkpoint" log || fail "the job began anew"
    same job.npy whole.npy
    refused "another job" mpirun -n 2 "$arboleda" "${command[@]}" --seed 2 "${with[@]}"
}

# A checkpoint that cannot be written ends the job, and leaves the one before as it was.
full() {
    local command=(shoot --scene fig4b --photons 4000000 --index wide-bvh --checkpoint full.checkpoint)
    quiet "$arboleda" "${command[@]}" --photon-range 0..1000000 --part full.part
    cp full.checkpoint before
    (
        trap '' XFSZ
        ulimit -f 8
        refused "cannot write full.checkpoint" "$arboleda" "${command[@]}" --checkpoint-every 0.1
    )
    same full.checkpoint before
    quiet "$arboleda" "${command[@]}" --out full.npy
    quiet "$arboleda" shoot --scene fig4b --photons 4000000 --index wide-bvh --out whole.npy
    same full.npy whole.npy
    echo "killed and resumed; a full device"
}

# --- Slurm ---

# Slurm's variables, and tasks in any order, of which one fails.
array() {
    each_job in_array
}

in_array() {
    local name=$1 all=$2 ending=$3 option=$4 task
    for task in 4 0 6 2 1 3 5 3; do
        SLURM_ARRAY_TASK_ID=$task SLURM_CPUS_PER_TASK=1 ARBOLEDA=$arboleda \
            quiet "$here/slurm-array.sh" 7 "$all" "parts-$name" "${@:5}"
        # The part is lost, and shot again when the task is sent again.
        [[ $task != 1 ]] || rm "parts-$name/0000003.part" 2>/dev/null || true
    done
    SLURM_ARRAY_TASK_ID=0 refused "parts of another job" "$here/slurm-array.sh" 7 "$all" "parts-$name" "${@:5}" --seed 9
    # shellcheck disable=SC2086
    quiet "$arboleda" merge "parts-$name"/*.part $option "array.$ending"
    same "array.$ending" "whole-$name.$ending"
    refused "are in" "$arboleda" merge "parts-$name"/*.part "parts-$name/0000002.part"
    head -c 100 "parts-$name/0000005.part" >"parts-$name/0000005.part.torn"
    mv "parts-$name/0000005.part.torn" "parts-$name/0000005.part"
    refused "0000005.part.* torn" "$arboleda" merge "parts-$name"/*.part
    rm "parts-$name/0000005.part"
    refused "are in no part" "$arboleda" merge "parts-$name"/*.part
    echo "$name: an array of 7 tasks"
}

# --- Dask ---

dask() {
    python3 -c "import dask.distributed" || fail "Dask is not installed: pip install dask distributed"
    each_job with_dask
}

with_dask() {
    local name=$1 all=$2 ending=$3 option=$4
    [[ $name == shoot || $name == gathered ]] || return 0
    local out=dask.npy more=
    [[ $ending != pfm ]] || { out=x.png more="--values dask.pfm"; }
    quiet python3 "$here/dask_parts.py" --arboleda "$arboleda" --parts 11 --all "$all" --folder "dask-$name" \
        --out "$out" --merge "$more" -- "${@:5}"
    same "dask.$ending" "whole-$name.$ending"
    refused "parts of another job" python3 "$here/dask_parts.py" --arboleda "$arboleda" --parts 12 --all "$all" \
        --folder "dask-$name" --out "$out" -- "${@:5}"
    echo "$name: Dask, two workers"
}

each_job whole
for check; do
    "$check"
done
