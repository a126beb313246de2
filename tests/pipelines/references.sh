#!/usr/bin/env bash
# References of a small cloud by render --integrator path: block means of three views, to 0.3 % of a view's mean.
# Usage: references.sh BIN puffs|blobs [SHARE] > data/references/CLOUD.txt; needs oiiotool.
#
#   SHARE   share of the samples, default 1: some minutes of processor time. The standard error grows as its square root.
#
# BIN/make_cloud makes the cloud: puffs at two optical depths in three media, blobs in one. The sun of irradiance 1
# stands towards 0.3,1,0.2; cameras are orthographic on the unit square, 24 x 24 pixels in 3 x 3 blocks. Block (a, b)
# covers a third of the cube along the view's first axis, from low to high, and along its second: x and z seen from
# above and below, x and y from the side. Samples: enough for 0.3 %, measured.
set -euo pipefail
bin=$(cd "$1" && pwd)
source "$(dirname "$0")/../../pipelines/benchmarks/views.sh"
cloud=$2
share=${3:-1}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# tau, albedo, g, samples a pixel from above, the side and below.
case $cloud in
    puffs)
        media=()
        for tau in 15 60; do
            media+=("$tau 0.99 0 600 700 1700" "$tau 1 0.85 42000 26000 3500" "$tau 0.9 0.5 1000 1000 800")
        done ;;
    blobs) media=("15 1 0.85 42000 26000 3500") ;;
    *) echo "references.sh: $cloud: expected puffs or blobs" >&2; exit 2 ;;
esac

# block_means TURN < lines "i j mean error": "a b mean error" of each block.
block_means() {
    awk -v turn="$1" "$cube_place"'
        {
            k = cube_place(turn, int($1 / 8), int($2 / 8), 2)
            sum[k] += $3 / 64; squares[k] += $4 * $4 / 4096
        }
        END { for (a = 0; a < 3; ++a) for (b = 0; b < 3; ++b) { k = a " " b; printf "%s %.6g %.2g\n", k, sum[k], sqrt(squares[k]) } }'
}

echo "# Radiance of the cloud of $cloud by unbiased light paths, made by tests/pipelines/references.sh build/bin $cloud $share"
echo "# tau albedo g view a b mean standard_error"
for medium in "${media[@]}"; do
    read -r tau albedo g samples_above samples_side samples_below <<< "$medium"
    "$bin/make_cloud" "$cloud" "$tau" cloud.vdb
    while read -r name camera turn; do
        samples=samples_$name
        spp=$(awk -v n="${!samples}" -v s="$share" 'BEGIN { printf "%d", n * s < 2 ? 2 : n * s }')
        "$bin/render" -q cloud.vdb --integrator path --spp "$spp" --albedo "$albedo" --g "$g" --sun 0.3,1,0.2 \
            "${cube_camera[@]}" --camera "$camera" --resolution 24 --aov standard_error -o view.exr
        # Channels: R, G, B, A, then the errors of R, G, B; all three colours are equal.
        oiiotool --dumpdata view.exr |
            sed -n 's/^ *Pixel (\([0-9]*\), \([0-9]*\)): \([^ ]*\) [^ ]* [^ ]* [^ ]* \([^ ]*\).*/\1 \2 \3 \4/p' |
            block_means "$turn" | sed "s/^/$tau $albedo $g $name /"
    done < <(cube_views)
done
