#!/usr/bin/env bash
# make versus-cycles: without blender it says so and ends with status 0. With blender, at tiny size, the pictures of our chain, of
# Cycles and of light paths have one mean and one brightness within their errors, and a second run makes nothing again.
# Usage: versus_cycles.sh BIN. Status 77: blender is not installed.
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "versus_cycles.sh: $*" >&2; [ ! -e "$folder/versus.csv" ] || cat "$folder/versus.csv" >&2; exit 1; }
unset MAKELEVEL MAKEFLAGS MFLAGS
versus() {
    make -s --no-print-directory -C "$top/pipelines/versus-cycles" BIN="$bin" OUT="$folder" \
        VOXELS=32 PIXELS=32 SAMPLES=128 CERTIFY=1
}

# A path of what make needs, and no blender.
mkdir "$folder/tools"
for tool in bash sh make mkdir seq tr realpath readlink sed awk dirname basename cat ln env; do
    ln -s "$(command -v $tool)" "$folder/tools"
done
said=$(PATH="$folder/tools" versus) || fail "without blender: status $?"
[ "$said" = "versus-cycles: skipped: blender is not installed: apt-get install blender" ] || fail "without blender it says '$said'"
[ ! -e "$folder/versus.csv" ] || fail "without blender there is a table"

command -v blender > /dev/null || { echo "versus_cycles.sh: blender is not installed" >&2; exit 77; }
versus > "$folder/said"
version=$(blender --version | sed -n 's/^Blender *\([0-9.]*\).*/\1/p;T;q')
grep -q "^Cycles of Blender $version " "$folder/said" || fail "the table does not say that Blender is $version"
# figure G NAME: of the row of blocks of 8x8 pixels.
figure() {
    awk -F, -v g="$1" -v name="$2" '
        NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
        $column["g"] == g && $column["block"] == 8 { print $column[name] }' "$folder/versus.csv"
}
# holds TEXT CONDITION
holds() { awk "BEGIN { exit !($2) }" || fail "$1: expected $2"; }

# Means. Noise: half widths of 95 % and a third more for safety. At g = 0 it is below 1.2 %, so that an albedo of 0.99 in place of
# 0.999 in one tool, 6 %, fails. Cycles's step is a voxel, 1.2 mean free paths here: with 512 samples its mean at g = 0 is that of
# light paths to 0.4 %. Three sweeps in such voxels err by -1.5 % at g = 0 and by 1.7 % at g = 0.85.
for row in "0 1.2 3" "0.85 6 4"; do
    read -r g noise sweeps <<< "$row"
    ours=$(figure $g chain_mean) theirs=$(figure $g cycles_mean) paths=$(figure $g paths_mean)
    half=$(figure $g cycles_mean_half_width) paths_half=$(figure $g paths_mean_half_width)
    holds "g = $g: noise of Cycles's mean" "$half > 0 && 100 * $half < $noise"
    holds "g = $g: Cycles less light paths" "($theirs / $paths - 1) ^ 2 < (0.005 + 1.33 * sqrt($half ^ 2 + $paths_half ^ 2)) ^ 2"
    holds "g = $g: chain less Cycles" "($ours / $theirs - 1) ^ 2 < (0.01 * $sweeps + 1.33 * $half) ^ 2"
    holds "g = $g: seconds at equal error" "$(figure $g seconds_at_equal_error_low) > 0"
done
# Blocks of 8x8 pixels, 4 along the edge of the picture: a turned or shifted picture, or another sun, is off by 20 % and more.
holds "difference of blocks at g = 0" "$(figure 0 difference_high) < 0.08"
holds "bias of Cycles at g = 0" "$(figure 0 cycles_bias_low) < 0.02"

# The .png: three pictures in each of two rows, the left and the right one of a row equally bright. Steps of 8 bits leave 0.3 %;
# noise that is clipped at white darkens that of Cycles, at g = 0 by less than 2 %.
for cut in 0 64; do
    oiiotool "$folder/versus.png" --cut "32x32+$cut+0" --ch 0 -o "$folder/cut.$cut.tif"
    mean[cut]=$(oiiotool --stats "$folder/cut.$cut.tif" | sed -n 's/.*Stats Avg: *\([0-9.]*\).*/\1/p')
done
holds "brightness of the pictures" "(${mean[0]} / ${mean[64]} - 1) ^ 2 < 0.03 ^ 2"

before=$(stat -c '%n %y' "$folder"/versus.* "$folder"/parts/*)
versus > /dev/null
[ "$before" = "$(stat -c '%n %y' "$folder"/versus.* "$folder"/parts/*)" ] || fail "a second run makes files again"

# README's picture by both tools: the same sky where nothing scatters, to steps of 8 bits, and the same lit sea within the noise of a few
# thousand paths: 3 % in the mean over a tenth of the picture. Another sun, another colour of the sea or no light of the sky is off by 20 % and more.
make -s --no-print-directory -C "$top/pipelines/versus-cycles" BIN="$bin" OUT="$folder/both" PICTURE=small hero > "$folder/said"
[ "$(grep -c '^| .* | [0-9]* | [0-9]* |$' "$folder/said")" = 2 ] || fail "hero: expected two rows: $(cat "$folder/said")"
# part FILE WIDTHxHEIGHT+X+Y CHANNEL: its mean.
part() {
    oiiotool "$1" --ch "$3" --cut "$2" --printstats -o "$folder/part.tif" | sed -n 's/.*Stats Avg: *\([0-9.]*\).*/\1/p'
}
hero=$folder/both/hero
for channel in R G B; do
    for at in +0+0 +140+0 +140+30; do
        holds "hero: sky at $at, $channel" "($(part "$hero/fractal-cumulus.png" "20x10$at" $channel) - $(part "$hero/cycles.png" "20x10$at" $channel)) ^ 2 < (2 / 255) ^ 2"
    done
    holds "hero: sea, $channel" "($(part "$hero/fractal-cumulus.exr" 70x20+0+70 $channel) / $(part "$hero/cycles.exr" 70x20+0+70 $channel) - 1) ^ 2 < 0.12 ^ 2"
done
