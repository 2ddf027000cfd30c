#!/bin/sh
# Submits the shards of a run to Slurm, and the merge after them. Prints the numbers of the jobs.
#   sh submit.sh            all shards
#   sh submit.sh 3,7,12-15  these shards
set -eu
run={{run}}
tasks=${1:-1-{{shards}}}
round=${2:-1}
# A federation adds the name of the cluster to the number of a job.
submitted() {
    job=$(sbatch --parsable --chdir="$run" "$@")
    job=${job%%;*}
    echo "$job"
}
# Tasks that resolve a verdict map first; none without a map.
map_tasks={{map_tasks}}
map=
if [ -n "$map_tasks" ]; then map=$(submitted --array="$map_tasks" "$run/slurm/map.sh"); fi
# What a task leaves of the map is resolved by the shards.
shards=$(submitted --array="$tasks" ${map:+"--dependency=afterany:$map"} "$run/slurm/shard.sh")
merge=$(submitted --dependency="afterany:$shards" "$run/slurm/merge.sh" "$round" "$shards")
echo ${map:+"$map"} "$shards" "$merge"
