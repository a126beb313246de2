#!/usr/bin/env bash
# One picture of one file by our programs and by vdb_render with physical settings: ratios of processor seconds, and the
# bias of both against quadrature for each pixel without a light grid (shadow rays at every node).
# Usage: picture.sh BIN [SIZE] [RESOLUTION]
set -euo pipefail
bin=$1 size=${2:-256} resolution=${3:-512}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# Seconds of processor time of a command, user and system.
cpu() { local TIMEFORMAT='%U %S'; { time "$@" >/dev/null 2>&1; } 2>&1 | awk '{print $1 + $2}'; }
median() { printf '%s\n' "$@" | sort -g | sed -n "$((($# + 1) / 2))p"; }
sum() { awk -v a="$1" -v b="$2" 'BEGIN {print a + b}'; }

# A cloud in a box of two world units, seen from the front; the sun is above to the right. vdb_render takes lengths in
# world units but coefficients per voxel, and has no phase function.
"$bin/fractalgen" --seed 7 --size "$size" -q -o cloud.vdb
sigma_t=15
voxel=$(vdb_print -l cloud.vdb | sed -n 's/.*[Vv]oxel size: *\[*\([0-9.e-]*\).*/\1/p' | head -n 1)
voxel=${voxel:-$(awk -v n="$size" 'BEGIN {print 2 / n}')}
per_voxel=$(awk -v s=$sigma_t -v h="$voxel" 'BEGIN {print s * h}')
camera=(--camera 0,0.5,4 --look-at 0,0.5,0 --fov 40 --resolution "$resolution")

light() { cpu "$bin/illuminate" cloud.vdb --extinction $sigma_t --sun 0.3,1,0.2 --error-samples 0 -q -o lit.vdb; }
picture() { cpu "$bin/render" lit.vdb "${camera[@]}" --aov none --background none -q -o ours.exr; }
theirs() {
    cpu vdb_render cloud.vdb theirs.exr -res "${resolution}x${resolution}" -camera perspective -translate 0,0.5,4 -lookat 0,0.5,0 \
        -focal 50 -aperture 36.397 -light 0.3,1,0.2,1,1,1 -absorb 0,0,0 -scatter "$per_voxel,$per_voxel,$per_voxel" -step 1 \
        -shadowstep 1 -gain 0 -cutoff 0 -cpus 1
}
for n in 1 2 3; do l[$n]=$(light); p[$n]=$(picture); done
t=$(theirs)
l=$(median "${l[@]}") p=$(median "${p[@]}")
echo "processor seconds, $size^3, ${resolution}x$resolution: illuminate $l, render $p, vdb_render $t"
awk -v o="$(sum "$l" "$p")" -v t="$t" 'BEGIN {printf "vdb_render over illuminate + render: %.1f\n", t / o}'

# Bias, at a resolution where shadow rays are affordable.
camera=(--camera 0,0.5,4 --look-at 0,0.5,0 --fov 40 --resolution 64)
"$bin/render" lit.vdb "${camera[@]}" --aov none --background none -q -o small.exr
"$bin/render" lit.vdb "${camera[@]}" --aov none --background none --shadow-rays -q -o reference.exr
vdb_render cloud.vdb small_theirs.exr -res 64x64 -camera perspective -translate 0,0.5,4 -lookat 0,0.5,0 -focal 50 -aperture 36.397 \
    -light 0.3,1,0.2,1,1,1 -absorb 0,0,0 -scatter "$per_voxel,$per_voxel,$per_voxel" -step 1 -shadowstep 1 -gain 0 -cutoff 0 >/dev/null 2>&1
mean() { oiiotool "$1" --ch R --printstats 2>/dev/null | sed -n 's/.*Stats Avg: *\([0-9.e+-]*\).*/\1/p' | head -n 1; }
a=$(mean small.exr) r=$(mean reference.exr) v=$(mean small_theirs.exr)
# vdb_render omits the factor 1 / (4 pi) of the phase function.
awk -v a="$a" -v r="$r" -v v="$v" 'BEGIN {printf "bias of the mean picture: ours %+.2f %%, vdb_render %+.2f %%\n", 100 * (a / r - 1), 100 * (v / (4 * 3.14159265358979) / r - 1)}'
