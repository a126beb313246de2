#!/usr/bin/env bash
# What of README's pipe could overlap: seconds of the clock in which its programs read and write files, medians of five rounds. A
# stage needs the last byte of its input before its first ray, and its output has no first byte before the last ray; so of
# each file only the writing of one program and the reading of the next can run beside each other.
# Usage: overlap.sh BIN
set -euo pipefail
bin=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
# phase FILE NAME: its seconds of the clock
phase() { awk -v name="\"$2\"," '$1 == "\"name\":" && $2 == name { found = 1 } found && $1 == "\"wall_seconds\":" { print $2 + 0; exit }' "$1"; }
for ((k = 0; k < 5; ++k)); do
    start=$(date +%s.%N)
    "$bin/fractalgen" --seed 7 -o - -q | "$bin/illuminate" - --sun 0.3,1,0.2 -o - -q | "$bin/render" - -o cloud.exr --png cloud.png -q
    end=$(date +%s.%N)
    # In a pipe a program's reading contains its waiting.
    "$bin/fractalgen" --seed 7 -o d.vdb -q --json f.json
    "$bin/illuminate" d.vdb --sun 0.3,1,0.2 -o l.vdb -q --json i.json
    "$bin/render" l.vdb -o cloud.exr --png cloud.png -q --json r.json
    awk -v s="$start" -v e="$end" -v fw="$(phase f.json write)" -v ir="$(phase i.json read)" -v iw="$(phase i.json write)" \
        -v rr="$(phase r.json read)" 'BEGIN { printf "%.3f %.3f %.3f %.3f %.3f\n", e - s, fw, ir, iw, rr }' >> rounds
done
median() { sort -g -k "$1,$1" rounds | sed -n 3p | cut -d ' ' -f "$1"; }
echo "| whole pipe [s] | fractalgen writes | illuminate reads | illuminate writes | render reads |"
echo "|--:|--:|--:|--:|--:|"
echo "| $(median 1) | $(median 2) | $(median 3) | $(median 4) | $(median 5) |"
