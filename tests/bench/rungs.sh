#!/usr/bin/env bash
# What each rung (data/rungs.txt) costs: processor seconds of each stage. Usage: rungs.sh BIN [SIZE [RESOLUTION]].
#
# The cumulus of README at SIZE^3 (default 128), extinction 100, albedo 0.9999, g 0.85, one sun; pictures of RESOLUTION^2 pixels (default
# 512). Light paths, whose time is proportional to the samples, take an eighth of the rung's samples; their seconds are multiplied by 8.
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
TIMEFORMAT='%U %S'
taken() { { time "$@" 2> /dev/null; } 2> time; awk '{ printf "%.2f", $1 + $2 }' time; }
value() { awk -v n="$2" -v option="$1" '$2 == option { print $(n + 3) }' "$top/data/rungs.txt"; }

"$bin/fractalgen" -q --seed 7 --size "${2:-128}" -o cloud.vdb
echo "| rung | illuminate [s] | p1solve [s] | render [s] | all [s] |"
echo "|--:|--:|--:|--:|--:|"
for rung in $(sed -n 's/^rung \([0-9]*\):.*/\1/p' "$top/data/rungs.txt"); do
    light=$(taken "$bin/illuminate" -q cloud.vdb --rung "$rung" --extinction 100 --albedo 0.9999 --g 0.85 --sun 0.6,1,0.4 -o light.vdb)
    solved=light.vdb solve=
    if [ "$(value --iterations "$rung")" != none ]; then
        solved=solved.vdb
        solve=$(taken "$bin/p1solve" -q light.vdb --rung "$rung" -o $solved)
    fi
    spp=() times=1
    if [ "$(value --integrator "$rung")" = path ]; then
        times=8
        spp=(--spp $(($(value --samples "$rung") / times)))
    fi
    picture=$(taken "$bin/render" -q $solved --rung "$rung" "${spp[@]}" --resolution "${3:-512}" -o picture.exr)
    awk -v n="$rung" -v a="$light" -v b="$solve" -v c="$picture" -v k=$times 'BEGIN {
        printf "| %d | %.2f | %s | %.2f | %.1f |\n", n, a, b, k * c, a + b + k * c }'
done
