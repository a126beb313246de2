#!/usr/bin/env bash
# Time of p1solve against grid size: one cumulus at 64^3 to 256^3, with SIZE=full up to 512^3.
# Usage: p1_scaling.sh BIN
set -euo pipefail
bin=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
sizes="64 128 256"
[ "${SIZE:-}" = full ] && sizes="$sizes 512"

echo "| grid | active voxels | iterations | memory of the equations a voxel | processor seconds, all of p1solve | ns a voxel |"
echo "|--:|--:|--:|--:|--:|--:|"
for size in $sizes; do
    "$bin/fractalgen" --seed 7 --size "$size" -q -o d.vdb
    "$bin/p1solve" d.vdb --extinction 14.3 --sun 0.3,1,0.2 --albedo 0.9999 --g 0 --reentry-rays 0 -q --json j.json -o o.vdb 2> said
    # number BLANKS KEY: a number of the report; keys of the report have two blanks before them, of its sections four.
    number() { sed -n "s/^ \{$1\}\"$2\": \([0-9.e+-]*\),\{0,1\}\$/\1/p" j.json | head -n 1; }
    awk -v n="$size" -v voxels="$(number 4 active_voxels)" -v its="$(number 6 iterations)" -v bytes="$(number 4 bytes_per_active_voxel)" \
        -v cpu="$(number 2 cpu_seconds)" \
        'BEGIN {printf "| %d^3 | %d | %d | %.0f B | %.2f | %.0f |\n", n, voxels, its, bytes, cpu, 1e9 * cpu / voxels}'
done
