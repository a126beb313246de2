#!/usr/bin/env bash
# Error and processor seconds of each rung (data/rungs.txt) on the cloud of puffs, against light paths.
# Usage: rungs.sh BIN [SAMPLES [CASE ...]]; a CASE is "tau albedo g". Prints rows of docs/rungs.md.
#
# Error: root mean square over blocks of 8 x 8 pixels of three views of 24 x 24 pixels, relative to the mean of a view, of
# data/references/puffs.txt, which has a standard error of 0.3 % of a view's mean. Light paths take SAMPLES a pixel
# (default 1000), so that their noise is below their bias: pictures of 24 x 24 pixels average little. Whole light paths, which have
# no bias, take ten times as many at g above 0.5, where single scattering towards the sun makes their noise.
# Status 1 if a rung errs by more than 1.2 times what the rung before errs by and by more than 1.2 %.
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
source "$top/pipelines/benchmarks/views.sh"
samples=${2:-1000}
shift $(($# < 2 ? $# : 2))
[ $# -gt 0 ] || set -- "15 0.99 0" "60 0.99 0" "15 1 0.85" "60 1 0.85"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# seconds FILE COMMAND: runs it, and adds its processor seconds to the file.
TIMEFORMAT='%U %S'
seconds() { { time "${@:2}" 2>&3; } 3>&2 2>> "$1"; }
# blocks: "NAME a b mean" of each block of the pictures NAME.exr, as in tests/pipelines/references.sh. oiiotool takes longer to start
# than to print: one for all.
blocks() {
    oiiotool --dumpdata above.exr side.exr below.exr | awk -F '[(,): ]+' -v views="$(cube_views | cut -d ' ' -f 1,3 | xargs)" "$cube_place"'
        BEGIN { n = split(views, word, " "); for (k = 1; k < n; k += 2) turn[word[k] ".exr"] = word[k + 1] }
        !/^ *Pixel/ { file = $1; next }
        { sum[substr(file, 1, length(file) - 4) " " cube_place(turn[file], int($3 / 8), int($4 / 8), 2)] += $5 / 64 }
        END { for (k in sum) print k, sum[k] }'
}

bad=0
echo "| optical depth, albedo, g | rung | mean from above, side, below | blocks | p1solve [s] |"
echo "|---|--:|--:|--:|--:|"
for medium in "$@"; do
    read -r tau albedo g <<< "$medium"
    "$bin/make_cloud" puffs "$tau" cloud.vdb
    before=
    for rung in $(sed -n 's/^rung \([0-9]*\):.*/\1/p' "$top/data/rungs.txt"); do
        rm -f time
        "$bin/illuminate" -q cloud.vdb --rung "$rung" --albedo "$albedo" --g "$g" --sun 0.3,1,0.2 -o light.vdb
        solved=light.vdb
        if ! awk -v n="$rung" '$1 == "p1solve" && $(n + 3) == "none" { found = 1 } END { exit !found }' "$top/data/rungs.txt"; then
            solved=solved.vdb
            seconds time "$bin/p1solve" -q light.vdb --rung "$rung" -o $solved 2> /dev/null
        fi
        spp=()
        ! awk -v n="$rung" '$2 == "--integrator" && $(n + 3) == "path" { found = 1 } END { exit !found }' "$top/data/rungs.txt" ||
            spp=(--spp "$(awk -v n="$rung" -v g="$g" -v samples="$samples" '
                $2 == "--gather" { whole = $(n + 3) == "-" } END { print samples * (whole && g > 0.5 ? 10 : 1) }' "$top/data/rungs.txt")")
        while read -r name camera _; do
            "$bin/render" -q $solved --rung "$rung" "${spp[@]}" "${cube_camera[@]}" --camera "$camera" \
                --resolution 24 -o "$name.exr"
        done < <(cube_views)
        blocks > found
        error=$(awk -v tau="$tau" -v w0="$albedo" -v g="$g" '
            NR == FNR { if ($1 == tau && $2 == w0 && $3 == g) { truth[$4 " " $5 " " $6] = $7; mean[$4] += $7 / 9 } next }
            { d = $4 - truth[$1 " " $2 " " $3]; square[$1] += d * d / 9; seen[$1] += $4 / 9 }
            END {
                for (v in mean) sum += square[v] / mean[v] ^ 2 / 3
                printf "%.2f", 100 * sqrt(sum)
                for (k = 1; k <= 3; ++k) { v = k == 1 ? "above" : k == 2 ? "side" : "below"; printf " %+.1f", 100 * (seen[v] / mean[v] - 1) }
            }' "$top/data/references/puffs.txt" found)
        read -r rms above side below <<< "$error"
        taken=$([ ! -e time ] || awk '{ s += $1 + $2 } END { printf "%.2f", s }' time)
        echo "| $tau, $albedo, $g | $rung | $above, $side, $below % | $rms % | $taken |"
        if [ -n "$before" ] && awk -v e="$rms" -v b="$before" 'BEGIN { exit !(e > 1.2 * b && e > 1.2) }'; then
            echo "rungs.sh: $medium: rung $rung errs by $rms %, the rung before by $before %" >&2
            bad=1
        fi
        before=$rms
    done
done
exit $bad
