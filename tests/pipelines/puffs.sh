#!/usr/bin/env bash
# References of the cloud of puffs by render --integrator path: block means of three views at two optical depths and
# three media, to 0.3 % of a view's mean. Usage: puffs.sh BIN [SHARE] > data/references/puffs.txt; needs oiiotool.
#
#   SHARE   share of the samples, default 1: 6 minutes of processor time. The standard error grows as its square root.
#
# BIN/make_puffs makes the cloud. The sun of irradiance 1 stands towards 0.3,1,0.2; cameras are orthographic on the unit
# square, 24 x 24 pixels in 3 x 3 blocks. Block (a, b) covers a third of the cube along the view's first axis, from low to
# high, and along its second: x and z seen from above and below, x and y from the side. Samples: enough for 0.3 %,
# measured.
set -euo pipefail
bin=$(cd "$1" && pwd)
share=${2:-1}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# view NAME CAMERA TURN: TURN maps a pixel's column i and row j (from the top) to the axes' thirds.
views=(
    "above 0.5,9,0.5 z-x"
    "side 0.5,0.5,9 xy"
    "below 0.5,-9,0.5 zx"
)

# block_means TURN < lines "i j mean error": "a b mean error" of each block.
block_means() {
    awk -v turn="$1" '
        {
            i = $1; j = $2
            if (turn == "xy") { a = i; b = 23 - j }
            if (turn == "z-x") { b = i; a = 23 - j }
            if (turn == "zx") { b = 23 - i; a = 23 - j }
            k = int(a / 8) " " int(b / 8)
            sum[k] += $3 / 64; squares[k] += $4 * $4 / 4096
        }
        END { for (a = 0; a < 3; ++a) for (b = 0; b < 3; ++b) { k = a " " b; printf "%s %.6g %.2g\n", k, sum[k], sqrt(squares[k]) } }'
}

echo "# Radiance of the cloud of puffs by unbiased light paths, made by tests/pipelines/puffs.sh build/bin $share"
echo "# tau albedo g view a b mean standard_error"
for tau in 15 60; do
    "$bin/make_puffs" $tau puffs.vdb
    for medium in "0.99 0 600 700 1700" "1 0.85 42000 26000 3500" "0.9 0.5 1000 1000 800"; do
        read -r albedo g samples_above samples_side samples_below <<< "$medium"
        for view in "${views[@]}"; do
            read -r name camera turn <<< "$view"
            samples=samples_$name
            spp=$(awk -v n="${!samples}" -v s="$share" 'BEGIN { printf "%d", n * s < 2 ? 2 : n * s }')
            "$bin/render" -q puffs.vdb --integrator path --spp "$spp" --albedo "$albedo" --g "$g" --sun 0.3,1,0.2 \
                --projection orthographic --ortho-width 1 --camera "$camera" --look-at 0.5,0.5,0.5 --resolution 24 \
                --aov standard_error -o view.exr
            # Channels: R, G, B, A, then the errors of R, G, B; all three colours are equal.
            oiiotool --dumpdata view.exr |
                sed -n 's/^ *Pixel (\([0-9]*\), \([0-9]*\)): \([^ ]*\) [^ ]* [^ ]* [^ ]* \([^ ]*\).*/\1 \2 \3 \4/p' |
                block_means "$turn" | sed "s/^/$tau $albedo $g $name /"
        done
    done
done
