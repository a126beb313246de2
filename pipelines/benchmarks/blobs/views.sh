#!/usr/bin/env bash
# Mean radiance of the unit cube seen from three sides. Usage: views.sh BIN FILE.vdb, prints "view radiance".
set -euo pipefail
bin=$1 file=$2
source "$(dirname "$0")/../views.sh"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
while read -r name camera _; do
    "$bin/render" "$file" -q "${cube_camera[@]}" --camera "$camera" --resolution 48 --samples 4 --aov none -o "$folder/$name.exr"
done < <(cube_views)
cd "$folder"
# --printstats rounds small numbers. oiiotool takes longer to start than to print: one for all.
oiiotool --dumpdata *.exr | awk '!/Pixel/ { name = $1; sub(/[.]exr$/, "", name) } /Pixel/ { sum[name] += $4; ++n[name] }
    END { for (name in sum) printf "%s %.6g\n", name, sum[name] / n[name] }'
