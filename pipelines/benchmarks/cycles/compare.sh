#!/usr/bin/env bash
# Light paths of render against those of Blender's Cycles, on one .vdb: processor seconds at equal noise.
# Usage: compare.sh BIN [small|full], prints a table. Needs blender (3.4 was measured), oiiotool and awk.
#
# The cloud of scene.sh at 128^3, albedo 0.99. Each tool makes two pictures of different seeds. The variance of a pixel is half
# the mean square of their difference. Variance times processor seconds does not depend on the number of samples: its ratio is
# that of the seconds to equal noise. Both numbers are of the whole rendering, user and system time; Blender's start is not
# counted, that of render is.
set -euo pipefail
command -v blender > /dev/null || { echo "compare.sh: blender is not installed: apt-get install blender" >&2; exit 77; }
. "$(dirname "$0")/scene.sh"
bin=$(cd "$1" && pwd)
pixels=128 cycles_samples=32 path_samples=24 size=128
[ "${2:-full}" = full ] || { pixels=32 cycles_samples=8 path_samples=32 size=48; }
albedo=0.99
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$bin/fractalgen" --size $size --seed 7 -q -o "$folder/cloud.vdb"

# by_cycles G SEED and by_path G SEED: a picture, $folder/TOOL.SEED.exr, and its processor seconds.
by_cycles() { cycles "$folder/cloud.vdb" $size $albedo "$1" $pixels $cycles_samples "$2" "$folder/cycles.$2.exr"; }
by_path() {
    "$bin/render" "$folder/cloud.vdb" -q --integrator path --extinction $extinction --albedo $albedo --g "$1" --sun $sun --sun-irradiance 1 \
        "${view[@]}" --resolution $pixels --spp $path_samples --seed "$2" --aov none --json "$folder/path.json" -o "$folder/path.$2.exr"
    awk '$1 == "\"cpu_seconds\":" { gsub(",", "", $2); print $2; exit }' "$folder/path.json"
}

printf '%-5s %-7s %8s %12s %12s %12s %14s\n' g tool samples seconds mean error 'noise^2 x s'
for g in 0 0.85; do
    for tool in cycles path; do
        seconds=$({ by_$tool $g 1; by_$tool $g 2; } | awk '{ sum += $1 } END { print sum / 2 }')
        oiiotool "$folder/$tool.1.exr" --ch R "$folder/$tool.2.exr" --ch R --sub --dup --mul -o "$folder/square.exr"
        samples=${tool}_samples
        printf '%s %s %s %s %s %s %s\n' $g $tool "${!samples}" "$seconds" "$(average "$folder/$tool.1.exr")" \
            "$(average "$folder/$tool.2.exr")" "$(average "$folder/square.exr")"
    done
done | awk -v pixels=$pixels '
    # Relative to the mean: error of the mean of both pictures; variance of a pixel.
    {
        mean[NR] = ($5 + $6) / 2; variance = $7 / 2 / mean[NR] ^ 2; error = sqrt(variance / 2) / pixels; cost[NR] = variance * $4
        printf "%-5s %-7s %8d %12.2f %12.6f %10.2f %% %14.4g\n", $1, $2, $3, $4, mean[NR], 100 * error, cost[NR]
        if (NR % 2 == 0) printf "%-5s path needs %.3f of the seconds of cycles at equal noise; mean %+.2f %%\n", $1, cost[NR] / cost[NR - 1], 100 * (mean[NR] / mean[NR - 1] - 1)
    }'
