#!/usr/bin/env bash
# What --dry-run says of the commands of the pipelines, and what they take: processor seconds and memory at the peak.
# Usage: estimates.sh BIN, prints a table. With PICTURE=small on small grids.
set -euo pipefail
bin=$(realpath "$1") tests=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export SAID=$folder/said
made() {
    local pipeline=$1
    shift
    local targets=("${@/#/$folder/$pipeline/}")
    make -s -C "$tests/../pipelines/$pipeline" BIN="$bin" OUT="$folder/$pipeline" PICTURE="${PICTURE:-full}" SPP=16 PARTS=1 THREADS=1 \
        LAUNCH="'$tests/bench/said_and_taken.sh'" "${targets[@]}" > "$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
}
made cumulus cumulus.png
made multiple-scattering cumulus.both.png
made ladder with.0.png with.3.png
PICTURE=small made cumulus cumulus.path.exr
PICTURE=small made cumulus-growth growth.simulated
made cumulus-growth paper.simulated
echo "| program | output | seconds said | taken | ratio | MB said | taken | ratio |"
echo "|---|---|--:|--:|--:|--:|--:|--:|"
awk '$1 == "run" { printf "| %s | %s | %.2f | %.2f | %.2f | %.0f | %.0f | %.2f |\n", $2, $3, $4, $5, $4 / $5, $6 / 1e6, $7 / 1e6, $6 / $7 }' "$SAID"
