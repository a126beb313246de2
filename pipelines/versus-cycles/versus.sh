#!/usr/bin/env bash
# Our chain against Blender's Cycles: versus.md, versus.csv and versus.png in OUT. The Makefile calls it.
# Usage: versus.sh BIN OUT VOXELS PIXELS SAMPLES CERTIFY ALBEDO. Needs blender, oiiotool and awk.
#
# Both tools get the scene of ../benchmarks/cycles/scene.sh. render --certify measures the error of our picture against light
# paths. Cycles makes two pictures of different seeds; versus.awk finds its noise, its bias against the same light paths, and
# the seconds at which its error equals ours. Seconds are processor time, user and system. Those of our chain are of three
# whole processes; those of Cycles are without Blender's start.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
width=2
. "$here/../benchmarks/cycles/scene.sh"
bin=$(cd "$1" && pwd) out=$2 voxels=$3 pixels=$4 samples=$5 half_width=$6 albedo=$7
calc() { awk "BEGIN { printf \"%.6g\", ($1) }"; }
# number KEY FILE: of a report's outermost object.
number() { sed -n "s/^  \"$1\": \([-0-9.e+]*\),\{0,1\}$/\1/p" "$2"; }
# certified KEY: of the certificate in certified.json. interval KEY: value, low and high.
certified() { sed -n "/^  \"certificate\": {/,/^  }/s/^    \"$1\": \([a-z0-9.e+-]*\),\{0,1\}$/\1/p" certified.json; }
interval() {
    awk -v key="\"$1\":" '$1 == key { inside = 1 } inside { sub(/,$/, "", $2); v[$1] = $2 }
        inside && /}/ { print v["\"value\":"], v["\"low\":"], v["\"high\":"]; exit }' certified.json
}
# by_cycles SAMPLES SEED OUT.exr: a picture by Cycles; prints its seconds.
by_cycles() { cycles cloud.vdb "$voxels" "$albedo" "$g" "$pixels" "$1" "$2" "$3"; }
# shown IN OUT.png EXPOSURE: before one sky, clipped at 1, sRGB. The same for the pictures of both tools.
shown() {
    local scale
    scale=$(calc "2 ^ $3")
    oiiotool "$1" --ch R,G,B,A --mulc "$scale,$scale,$scale,1" \
        --pattern constant:color=0.2,0.3,0.45,1 "${pixels}x$pixels" 4 --over \
        --ch R,G,B --clamp:min=0:max=1 --colorconvert linear sRGB -d uint8 -o "$2"
}

blender=$(blender --version | sed -n 's/^Blender *\([0-9.]*\).*/\1/p;T;q')
rm -rf "$out/parts"
mkdir -p "$out/parts"
cd "$out/parts"
"$bin/fractalgen" --size "$voxels" --seed 7 -q -o cloud.vdb
for case in "0 1" "0.85 2"; do
    read -r g times <<< "$case"
    "$bin/illuminate" cloud.vdb -q --extinction $extinction --albedo "$albedo" --g "$g" --sun $sun --sun-irradiance 1 \
        -o light.vdb --json illuminate.json
    "$bin/p1solve" light.vdb -q --iterations 3 -o scatter.vdb --json p1solve.json
    picture=(scatter.vdb -q "${view[@]}" --resolution "$pixels")
    "$bin/render" "${picture[@]}" -o "chain.$g.exr" --json render.json
    seconds=0
    for stage in illuminate p1solve render; do seconds=$(calc "$seconds + $(number cpu_seconds $stage.json)"); done
    "$bin/render" "${picture[@]}" --certify "$(calc "$half_width * $times")%" -o certified.exr --json certified.json

    cycles_seconds=0
    for seed in 1 2; do
        once=$(by_cycles "$samples" $seed "cycles.$g.$seed.exr")
        cycles_seconds=$(calc "$cycles_seconds + $once / 2")
    done
    # The number of samples that takes the chain's seconds.
    few=$(awk -v n="$samples" -v a="$seconds" -v b="$cycles_seconds" \
        'BEGIN { k = int(n * a / b + 0.5); print (k < 1 ? 1 : k > n ? n : k) }')
    few_seconds=$(by_cycles "$few" 3 "cycles.$g.few.exr")

    # One picture of six channels: chain, Cycles twice, alpha, measured error of the block and its standard error. No .exr, which
    # would sort them.
    oiiotool certified.exr --ch R "cycles.$g.1.exr" --ch R --chappend "cycles.$g.2.exr" --ch R --chappend \
        certified.exr --ch A,block_error.R,block_deviation.Y --chappend -d float -o all.tif
    oiiotool --dumpdata all.tif | awk -v pixels="$pixels" -v g="$g" -v blender="$blender" -v voxels="$voxels" \
        -v albedo="$albedo" -v seconds="$seconds" -v samples="$samples" -v cycles_seconds="$cycles_seconds" -v few="$few" \
        -v few_seconds="$few_seconds" -v paths="$(certified luminance)" -v reliable="$(certified reliable)" \
        -v mean="$(interval mean)" -v rms8="$(interval rms_8x8)" -v rms32="$(interval rms_32x32)" \
        -f "$here/versus.awk" >> rows.csv

    exposure=$(calc "$(number exposure render.json) - 0.5")
    for picture in "chain.$g" "cycles.$g.few" "cycles.$g.1"; do
        shown "$picture.exr" "$picture.png" "$exposure"
        echo "$picture.png" >> pictures
    done
done
mapfile -t pictures < pictures
oiiotool "${pictures[@]}" --mosaic 3x2 -o versus.png
awk -F, 'NR == 1 || !/^g,/' rows.csv > versus.csv
awk -f "$here/table.awk" versus.csv > versus.md
mv versus.csv versus.png versus.md ..
