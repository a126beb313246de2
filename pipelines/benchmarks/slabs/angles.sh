#!/usr/bin/env bash
# Radiance that leaves a periodic slab under a sun at the zenith, by the angle between the ways of the sun's light and of
# the light that is seen. Usage: angles.sh BIN FILE.vdb TOP REPORTS ANGLE..., prints "angle radiance" and writes the
# reports of render to REPORTS.ANGLE.json. TOP is the height of the slab, which stands on y = 0.
set -euo pipefail
bin=$(realpath "$1") file=$(realpath "$2") top=$3 reports=$(realpath "$4")
shift 4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
for angle; do
    read -r camera direction < <(awk -v angle="$angle" -v top="$top" 'BEGIN {
        angle *= 3.14159265358979 / 180
        x = sin(angle); y = -cos(angle)  # of the light that is seen; the camera stands in its way
        printf "%.9g,%.9g,0 %.9g,%.9g,0\n", 9 * top * x, (y > 0 ? top : 0) + 9 * top * y, -x, -y }')
    "$bin/render" "$file" -q --projection orthographic --camera="$camera" --direction="$direction" --ortho-width 0.01 --resolution 1 \
        --aov none --json "$reports.$angle.json" -o "$angle.exr"
done
# oiiotool takes longer to start than to print: one for all.
oiiotool --dumpdata "${@/%/.exr}" | awk '!/Pixel/ { angle = $1; sub(/[.]exr$/, "", angle) } /Pixel/ { print angle, $4 }'
