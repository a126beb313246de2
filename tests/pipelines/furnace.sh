#!/usr/bin/env bash
# The white furnace through the programs: a medium that absorbs nothing, under a sky of radiance 1 all around, is not to be
# seen at all, whatever its density, forward scattering and voids included.
# Usage: furnace.sh BIN
set -euo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fractalgen --seed 3 --size 48 --envelope sphere --coverage 0.3 --edge 0.02 -q -o clumps.vdb
# P1, and the sweeps that close it with moments up to a degree.
for run in "0 0 1" "0.85 0 1" "0.85 2 1" "0.85 2 3"; do
    read -r g iterations degree <<< "$run"
    sweeps=()
    [ "$iterations" = 0 ] || sweeps=(--iterations "$iterations" --degree "$degree" --change 1e-9)
    p1solve clumps.vdb --albedo 1 --g $g --sky 1 --tolerance 1e-7 "${sweeps[@]}" -q -o lit.vdb
    render lit.vdb --resolution 64 --background 1,1,1 --aov all -q -o furnace.exr
    # The picture is stored as half, which rounds at 5e-4 near 1.
    oiiotool furnace.exr --ch R,G,B --printstats > stats
    low=$(sed -n 's/.*Stats Min: *\([0-9.]*\).*/\1/p' stats) high=$(sed -n 's/.*Stats Max: *\([0-9.]*\).*/\1/p' stats)
    echo "g = $g, $iterations sweeps, degree $degree: radiance from $low to $high"
    awk -v l="$low" -v h="$high" 'BEGIN {exit !(l > 0.9990 && h < 1.0010)}' || { echo "furnace.sh: g = $g: expected 1 everywhere" >&2; exit 1; }
    dark=$(oiiotool furnace.exr --ch transmittance.R --printstats | sed -n 's/.*Stats Min: *\([0-9.]*\).*/\1/p')
    awk -v t="$dark" 'BEGIN {exit !(t != "" && t < 0.1)}' || { echo "furnace.sh: the medium is thin (T >= $dark): nothing is tested" >&2; exit 1; }
done
