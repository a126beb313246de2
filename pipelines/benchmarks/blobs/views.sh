#!/usr/bin/env bash
# Mean radiance of the unit cube seen from three sides. Usage: views.sh BIN FILE.vdb, prints "view radiance".
set -euo pipefail
bin=$1 file=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
while read -r name camera; do
    "$bin/render" "$file" -q --projection orthographic --ortho-width 1 --camera "$camera" --look-at 0.5,0.5,0.5 --resolution 48 \
        --samples 4 --aov none -o "$folder/view.exr"
    # --printstats rounds small numbers.
    oiiotool --dumpdata "$folder/view.exr" | awk -v name="$name" '/Pixel/ { sum += $4; ++n } END { printf "%s %.6g\n", name, sum / n }'
done <<< "above 0.5,9,0.5
side 0.5,0.5,9
below 0.5,-9,0.5"
