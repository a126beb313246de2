#!/usr/bin/env bash
# A pipe of three programs and a chain of files give equal pictures on any number of threads. Programs of OpenVDB list and
# open the files. With default options the light lattice differs from exact rays by less than 1e-3.
# Usage: chain.sh BIN. VDBCLOUD_REAL=folder adds the Disney cloud.
set -euo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "chain.sh: $*" >&2; exit 1; }

fractalgen --seed 7 --size 128 -q -o - | illuminate - --sun 0.3,1,0.2 --g 0.3 --albedo 0.99 -q -o - |
    render - --resolution 96 --aov all -q -o pipe.exr
fractalgen --seed 7 --size 128 -q --threads 1 -o density.vdb
illuminate density.vdb --sun 0.3,1,0.2 --g 0.3 --albedo 0.99 -q --threads 1 -o light.vdb
render light.vdb --resolution 96 --aov all -q --threads 1 -o files.exr --png files.png
cmp pipe.exr files.exr || fail "a pipe and files give different pictures"
illuminate density.vdb --sun 0.3,1,0.2 --g 0.3 --albedo 0.99 -q --threads 2 -o again.vdb
vdbdiff light.vdb again.vdb -q || fail "two runs of illuminate differ"
! vdbdiff density.vdb light.vdb -q >/dev/null 2>&1 || fail "vdbdiff accepts a file that lacks a grid"

# Alpha of a cloud: 0 somewhere, above 0.99 somewhere, in between on the mean.
read -r low mean high < <(oiiotool files.exr --ch A --printstats |
    sed -n 's/.*Stats Min: *\([0-9.]*\).*/\1/p; s/.*Stats Avg: *\([0-9.]*\).*/\1/p; s/.*Stats Max: *\([0-9.]*\).*/\1/p' | tr '\n' ' ' |
    awk '{print $1, ($2 < $3 ? $2 : $3), ($2 < $3 ? $3 : $2)}')
awk -v l="$low" -v m="$mean" -v h="$high" 'BEGIN {exit !(l == 0 && m > 0.1 && m < 0.9 && h > 0.99)}' ||
    fail "alpha of the picture: min $low, mean $mean, max $high"

for file in density light; do
    text=$(vdb_print -l $file.vdb 2>&1)
    ! grep -qE '(ERROR|WARNING|Error|Exception):' <<<"$text" || fail "vdb_print complains of $file.vdb"
    grep -q 'Name: density' <<<"$text" || fail "vdb_print does not list density in $file.vdb"
    text=$(vdb_tool -read $file.vdb -print 2>&1)
    grep -q '"density"' <<<"$text" || fail "vdb_tool does not open $file.vdb"
done
text=$(vdb_print -m light.vdb)
grep -q 'fractalgen.*seed=7' <<<"$text" || fail "light.vdb: the history lacks the line of fractalgen"

clouds=(density.vdb)
if [ -e "${VDBCLOUD_REAL:-}/wdas_cloud_sixteenth.vdb" ]; then clouds+=("$VDBCLOUD_REAL/wdas_cloud_sixteenth.vdb")
else echo "skipped: the Disney cloud (no wdas_cloud_sixteenth.vdb in VDBCLOUD_REAL)"; fi
for cloud in "${clouds[@]}"; do
    illuminate "$cloud" --sun 0.3,1,0.2 -q --json report.json -o lit.vdb
    error=$(sed -n 's/.*"mean_transmittance_error": *\([0-9.e-]*\).*/\1/p' report.json)
    echo "mean transmittance error of the default on $(basename "$cloud"): $error"
    awk -v e="$error" 'BEGIN {exit !(e != "" && e > 0 && e < 1e-3)}' || fail "the lattice errs by $error on $cloud: expected below 1e-3"
done
