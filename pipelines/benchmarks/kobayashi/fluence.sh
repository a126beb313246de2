#!/usr/bin/env bash
# Fluence at points by pictures from each point: the sum of radiance times solid angle over the pixels of the faces of
# a cube, or, where the only source is the cube |x|, |y|, |z| < 10, over a picture that holds that cube.
# Usage: fluence.sh BIN FILE.vdb POINTS i|ii RESOLUTION SAMPLES EVERY, prints "x y z fluence standard_error" for each
# point, or for the first of every 2, 3, ... points.
#
#   i    light that was not scattered, by integrals along rays: no noise, 0 for the standard error
#   ii   albedo 0.5, by light paths
#
# The weight of a pixel is the solid angle at its centre: at 32 pixels this is off by 0.1 % in a uniform field.
set -euo pipefail
bin=$1 file=$2 points=$3 case=$4 resolution=$5 samples=$6 every=$7
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# view POINT DIRECTION FOV PICTURE. Without a lamp of its own render would add a sun.
view() {
    local how=(--integrator cells --albedo 0 --aov none)
    [ "$case" = i ] || how=(--integrator path --albedo 0.5 --aov standard_error)
    "$bin/render" "$file" -q --sun 0,1,0 --sun-irradiance 0 "${how[@]}" --samples "$samples" --camera="$1" \
        --direction="$2" --fov "$3" --resolution "$resolution" -o "$folder/$4.exr"
}
# pixels PICTURE...: "column row radiance error" of each pixel. oiiotool takes longer to start than to print: one for all.
pixels() {
    oiiotool --dumpdata "${@/#/$folder/}" | sed -n 's/^ *Pixel (\([0-9]*\), \([0-9]*\)): \([^ ]*\) [^ ]* [^ ]* [^ ]* *\([^ ]*\).*/\1 \2 \3 \4/p'
}

awk -v every="$every" '!/^#/ && n++ % every == 0' "$points" | while read -r x y z; do
    fov=$(awk -v x="$x" -v y="$y" -v z="$z" 'BEGIN {
        d = sqrt(x * x + y * y + z * z); r = 21  # the cube and a voxel about it
        printf "%.6g", (d > 2 * r ? 2 * atan2(r, sqrt(d * d - r * r)) * 57.2957795 : 90) }')
    if [ "$case" = i ] && [ "$fov" != 90 ]; then directions=$(awk -v x="$x" -v y="$y" -v z="$z" 'BEGIN { printf "%.9g,%.9g,%.9g", -x, -y, -z }')
    else fov=90 directions="1,0,0 -1,0,0 0,1,0 0,-1,0 0,0,1 0,0,-1"; fi
    pictures=()
    for direction in $directions; do
        view "$x,$y,$z" "$direction" "$fov" "${#pictures[@]}"
        pictures+=("${#pictures[@]}.exr")
    done
    pixels "${pictures[@]}" | awk -v n="$resolution" -v fov="$fov" -v at="$x $y $z" '
        BEGIN { half = fov * 3.14159265358979 / 360; t = sin(half) / cos(half) }
        {
            u = t * (2 * ($1 + 0.5) / n - 1); v = t * (2 * ($2 + 0.5) / n - 1)
            solid = (2 * t / n) ^ 2 / (1 + u * u + v * v) ^ 1.5
            sum += solid * $3; squares += (solid * $4) ^ 2
        }
        END { printf "%s %.6g %.2g\n", at, sum, sqrt(squares) }'
done
