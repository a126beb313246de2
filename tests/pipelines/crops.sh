#!/usr/bin/env bash
# Crops of one picture, as jobs of an array make them, put together by oiiotool: the whole picture in every bit, with solids, whose rays
# are drawn at random, and with many samples.
# Usage: crops.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "crops.sh: $*" >&2; exit 1; }
cd "$folder"
"$bin/fractalgen" -q --size 32 -o cloud.vdb
"$bin/p1solve" -q cloud.vdb --sun 1,1,0.5 --extinction 20 --albedo 0.99 -o lit.vdb --solid 'plane; at=0,-0.1,0'
view=(lit.vdb -q --resolution 64x48 --camera 0.2,0.7,4 --look-at 0,0.4,0 --samples 2 --filter gaussian --background none)
"$bin/render" "${view[@]}" -o whole.exr
job=0
for y in 0 24; do
    for x in 0 20 40; do
        "$bin/render" "${view[@]}" --crop $x,$y,$((x == 40 ? 64 : x + 20)),$((y + 24)) -o crop.$((job++)).exr
    done
done
oiiotool crop.0.exr crop.1.exr --add crop.2.exr --add crop.3.exr --add crop.4.exr --add crop.5.exr --add -o sum.exr
idiff -q -fail 0 -warn 0 sum.exr whole.exr || fail "the crops together are another picture"
! idiff -q -fail 0 -warn 0 crop.0.exr whole.exr > said 2>&1 || fail "one crop is the whole"
