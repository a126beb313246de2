#!/usr/bin/env bash
# Moments as 16-bit floats (p1solve --half) against 32 bits: size of the file, and difference of the picture. Both runs read
# a density that is rounded to 16 bits, so that the difference is due to the moments alone.
# Usage: half_moments.sh BIN [SIZE]
set -euo pipefail
bin=$1 size=${2:-96}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$bin/fractalgen" --seed 7 --size "$size" --half -q -o d.vdb
"$bin/illuminate" d.vdb --extinction 20 --albedo 0.999 --g 0.85 --sun 0.3,1,0.2 -q -o l.vdb
for degree in 3 7; do
    directions=$((degree == 3 ? 64 : 256))
    "$bin/p1solve" l.vdb --degree $degree --directions $directions --iterations 3 --change 1e-9 -q -o full.vdb
    "$bin/p1solve" l.vdb --degree $degree --directions $directions --iterations 3 --change 1e-9 --half -q -o half.vdb
    for name in full half; do "$bin/render" $name.vdb --resolution 256 -q -o $name.exr; done
    echo "degree $degree: $(stat -c %s full.vdb half.vdb | paste -sd' ') bytes"
    oiiotool full.exr --stats | grep "Avg" || true
    oiiotool full.exr half.exr --diff | grep -E "Mean|RMS|Max" || true
done
