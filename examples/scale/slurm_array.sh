#!/bin/bash
# Meshes one Zarr store by a Slurm array, a part a task. In a folder with ship.toml:
#
#     sbatch slurm_array.sh ship.toml ship.zarr
#
# and when all tasks are done:
#
#     hexcast merge ship.zarr.reports/*.json -o ship.json
#     hexcast verify-store ship.zarr
#
# A task that fails or is killed is submitted again, such as by: sbatch --array=17 --export=ALL,PARTS=64 slurm_array.sh ship.toml ship.zarr
#SBATCH --job-name=hexcast
#SBATCH --array=1-64
#SBATCH --cpus-per-task=4
#SBATCH --mem=8G
#SBATCH --time=00:30:00
#SBATCH --requeue
set -euo pipefail
# Slurm says in MiB what --mem allows; a quarter is left to the files that the system keeps in memory

job=$1
store=$2
parts=${PARTS:-$SLURM_ARRAY_TASK_COUNT}
mkdir -p "$store.reports"
exec hexcast mesh --job "$job" --part "$SLURM_ARRAY_TASK_ID/$parts" -o "$store" \
  --report "$store.reports/$SLURM_ARRAY_TASK_ID.json" --threads "${SLURM_CPUS_PER_TASK:-1}" \
  --max-memory "$((${SLURM_MEM_PER_NODE:-8192} * 3 / 4))MiB" --quiet
