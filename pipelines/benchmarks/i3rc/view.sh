#!/usr/bin/env bash
# Radiance of a periodic cloud by column of voxels: a picture one pixel wide whose rays meet a horizontal plane at the columns.
# Usage: view.sh BIN FILE.vdb WIDTH TOP COLUMNS VIEW REPORT.json, prints "column radiance", columns from 0 at x = 0.
#
#   WIDTH, TOP   extent of the period along x, height of the cloud's top [m]
#   VIEW         Iu: from above; Id: from below, straight up; I601: from above, 60 degrees off the zenith, light that travels
#                towards +x; I602: the same towards -x. All but Id by where rays meet the top.
set -euo pipefail
bin=$1 file=$2 width=$3 top=$4 columns=$5 report=$7
# Direction of the camera; extent of a pixel on the plane over that across the rays; whether rows of the picture, which
# begin at the upper edge, run along +x.
case $6 in
Iu) direction="0 -1" stretch=1 along=0;;
Id) direction="0 1" top=0 stretch=1 along=0;;
I601) direction="-0.8660254038 -0.5" stretch=2 along=1;;
I602) direction="0.8660254038 -0.5" stretch=2 along=0;;
esac
read -r dx dy <<< "$direction"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
read -r camera pixel < <(awk -v w="$width" -v h="$top" -v n="$columns" -v dx="$dx" -v dy="$dy" -v stretch="$stretch" 'BEGIN {
    printf "%.9g,%.9g,0 %.9g\n", w / 2 - w * dx, h - w * dy, w / n / stretch }')
"$bin/render" "$file" -q --projection orthographic --camera="$camera" --direction="$dx,$dy,0" --ortho-width "$pixel" \
    --resolution "1x$columns" --samples 4 --aov none --json "$report" -o "$folder/view.exr"
oiiotool --dumpdata "$folder/view.exr" | awk -v along="$along" -v n="$columns" '
    /Pixel/ { row = $3 + 0; print along ? row : n - 1 - row, $4 }'
