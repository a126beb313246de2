#!/usr/bin/env bash
# The pipeline of the intercomparison cases, small: a table with a number for each published range, profiles, a picture; a
# second make makes nothing. Usage: les.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "les.sh: $*" >&2; exit 1; }
les() { make -s -C "$top/pipelines/les" PICTURE=small BIN="$bin" OUT="$folder" > "$folder/said" 2>&1 || { cat "$folder/said" >&2; fail "status $?"; }; }
les
wanted=$(grep -c '^bomex,' "$top/pipelines/les/published.csv")
# Columns 3 to 5: the range, and ours, which is above 0.
awk -F, -v wanted="$wanted" 'NR > 1 && $1 == "bomex" && $3 < $4 && $5 > 0 { ++n } END { exit n != wanted }' "$folder/bomex.table.csv" ||
    { cat "$folder/bomex.table.csv" >&2; fail "the table"; }
# Base and top of coarse clouds lie in the cloud layer.
awk -F, '$2 == "cloud_base" && ($5 < 400 || $5 > 900) || $2 == "cloud_top" && ($5 < 1200 || $5 > 2400) { exit 1 }' "$folder/bomex.table.csv" ||
    { cat "$folder/bomex.table.csv" >&2; fail "cloud base or top"; }
grep -q '<path' "$folder/bomex.svg" || fail "no curves in the plot"
[ -s "$folder/bomex.png" ] || fail "no picture"
les
! grep -q 'bomex.png' "$folder/said" || fail "a second make made the picture again"
