#!/usr/bin/env bash
# Whether `make ERROR=P%` holds what it promises: each pipeline climbs to 10, 3 and 1 %, and the picture that it ends with is measured
# again, for longer and by other light paths.
# Usage: bounds.sh BIN [PIPELINE ...]   pipelines of pipelines/ that take ERROR; "any" with DENSITY=path, "disney" with VDBCLOUD_REAL
#   PICTURE=small|full   TIME=300: seconds of the clock for a climb   AGAIN=120: seconds of the second measurement
set -euo pipefail
bin=$(cd "$1" && pwd)
shift
[ $# -gt 0 ] || set -- cumulus fractal-cumulus multiple-scattering
top=$(cd "$(dirname "$0")/../.." && pwd)
export PICTURE=${PICTURE:-small} TIME=${TIME:-300}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
unset MAKELEVEL MAKEFLAGS MFLAGS
# percent FILE: error, low and high of the blocks of 32 x 32 pixels, of a report.
percent() {
    awk '$1 == "\"rms_32x32\":" { inside = 1 }
        inside { key = $1; gsub(/[":]/, "", key); sub(/,$/, "", $2); if (key ~ /^(value|low|high)$/) v[key] = 100 * $2 }
        inside && /}/ { exit }
        END { if (!("value" in v)) exit 1; printf "%.2g (%.2g to %.2g) %%", v["value"], v["low"], v["high"] }' "$1"
}
echo "| pipeline | asked | rung | certified, 95 % | measured again | seconds of the climb |"
echo "|---|--:|--:|--:|--:|--:|"
for pipeline in "$@"; do
    for asked in 10 3 1; do
        SECONDS=0 status=0
        make -s --no-print-directory -C "$top/pipelines/$pipeline" BIN="$bin" OUT="$out/$pipeline" ERROR=$asked% > "$out/said" 2>&1 || status=$?
        seconds=$SECONDS
        read -r name rung <<< "$(sed -n 's/^\([^ ]*\): rung \([0-9]*\) holds .*/\1 \2/p' "$out/said")"
        if [ $status != 0 ] || [ -z "$rung" ]; then
            grep -q 'the time ended\|no rung holds' "$out/said" || { cat "$out/said" >&2; exit 1; }
            echo "| $pipeline | $asked % | none in $TIME s | | | $seconds |"
            continue
        fi
        folder=$out/$pipeline/rung$rung
        if grep -q '"rms_32x32"' "$folder/$name.json"; then
            certified=$(percent "$folder/$name.json")
            rm "$folder/$name.exr"
            make -s --no-print-directory -C "$top/pipelines/$pipeline" PLACED=1 BIN="$bin" OUT="$folder" RUNG="$rung" \
                climb_flags="--seed 4711 --certify ${AGAIN:-120} --json $out/again.json" "$folder/$name.exr" > "$out/said"
            measured=$(percent "$out/again.json")
        else
            certified="noise of $(awk '$1 == "\"noise\":" { sub(/,$/, "", $2); printf "%.2g", 100 * $2 / 32; exit }' "$folder/$name.json") %"
            measured="paths have no bias"
        fi
        echo "| $pipeline | $asked % | $rung | $certified | $measured | $seconds |"
    done
done
