#!/usr/bin/env bash
# Time against grid size: processor seconds of each stage for one cumulus at 64^3 to 512^3, medians of three runs.
# Usage: scaling.sh BIN [RESOLUTION]
set -euo pipefail
bin=$1 resolution=${2:-512}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cpu() { local TIMEFORMAT='%U %S'; { time "$@" >/dev/null 2>&1; } 2>&1 | awk '{print $1 + $2}'; }
median() { for _ in 1 2 3; do cpu "$@"; done | sort -g | sed -n 2p; }

echo "| grid | active voxels | fractalgen | illuminate | render ${resolution}x$resolution | ns a voxel, first two |"
echo "|--:|--:|--:|--:|--:|--:|"
for size in 64 128 256 512; do
    f=$(median "$bin/fractalgen" --seed 7 --size $size -q -o d.vdb)
    i=$(median "$bin/illuminate" d.vdb --extinction 11 --sun 0.3,1,0.2 --error-samples 0 -q -o l.vdb)
    r=$(median "$bin/render" l.vdb --resolution "$resolution" -q -o p.exr)
    "$bin/illuminate" d.vdb --dry-run --json j.json -o l.vdb >/dev/null 2>&1
    voxels=$(sed -n 's/.*"active_voxels": *\([0-9]*\).*/\1/p' j.json | head -n 1)
    awk -v s=$size -v v="$voxels" -v f="$f" -v i="$i" -v r="$r" \
        'BEGIN {printf "| %d^3 | %d | %.2f s | %.2f s | %.2f s | %.0f |\n", s, v, f, i, r, 1e9 * (f + i) / v}'
done
