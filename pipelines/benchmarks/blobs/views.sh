#!/usr/bin/env bash
# Mean radiance of the unit cube seen from three sides. Usage: views.sh BIN FILE.vdb, prints "view radiance".
set -euo pipefail
bin=$1 file=$2
source "$(dirname "$0")/../views.sh"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
while read -r name camera _; do
    "$bin/render" "$file" -q "${cube_camera[@]}" --camera "$camera" --resolution 48 --samples 4 --aov none -o "$folder/view.exr"
    # --printstats rounds small numbers.
    oiiotool --dumpdata "$folder/view.exr" | awk -v name="$name" '/Pixel/ { sum += $4; ++n } END { printf "%s %.6g\n", name, sum / n }'
done < <(cube_views)
