#!/usr/bin/env bash
# How multiple scattering grows with the grid: p1solve on the same cumulus at 64^3 to 256^3, with SIZE=full to 512^3.
# Usage: p1_scaling.sh BIN
set -euo pipefail
bin=$1
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
    python3 - "$size" <<'PY'
import json, sys
j = json.load(open("j.json"))
voxels, cpu = j["counts"]["active_voxels"], j["cpu_seconds"]
print("| %s^3 | %d | %d | %.0f B | %.2f | %.0f |" % (sys.argv[1], voxels, j["channels"]["r"]["iterations"],
      j["memory"]["bytes_per_active_voxel"], cpu, 1e9 * cpu / voxels))
PY
done
