#!/usr/bin/env bash
# The white furnace: under a sky of radiance 1 in all directions, radiance is 1 everywhere in and behind a medium that
# absorbs nothing, whatever its density; also with forward scattering and with voids.
# Usage: furnace.sh BIN
set -euo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fractalgen --seed 3 --size 48 --envelope sphere --coverage 0.3 --edge 0.02 -q -o clumps.vdb
# P1, and sweeps with moments to degree 1 and 3.
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
    awk -v t="$dark" 'BEGIN {exit !(t != "" && t < 0.1)}' || { echo "furnace.sh: the smallest transmittance is $dark: the test needs a medium below 0.1" >&2; exit 1; }
done

# The flux limiter changes nothing where light is uniform. p1solve refuses it with sweeps, with a series and with another
# solver.
p1solve clumps.vdb --albedo 1 --g 0.85 --sky 1 --tolerance 1e-7 --limiter levermore-pomraning -q --json limited.json -o limited.vdb
awk -F: '/"(smallest|largest)"/ {gsub(/[ ,]/, "", $2); if ($2 < 12.5651 || $2 > 12.5677) bad = 1; ++n} END {exit bad || n < 2}' limited.json ||
    { echo "furnace.sh: --limiter leaves the furnace: $(grep -E 'smallest|largest' limited.json | xargs)" >&2; exit 1; }
for other in "--iterations 2" "--series 3" "--solver relaxation"; do
    status=0
    p1solve clumps.vdb --limiter levermore-pomraning $other -q -o x.vdb 2> said || status=$?
    [ "$status" = 2 ] && [ "$(wc -l < said)" = 1 ] || { echo "furnace.sh: --limiter $other: status $status, $(cat said)" >&2; exit 1; }
done

# The .png shows the sky of the file as background: against it the medium is invisible too.
render lit.vdb --resolution 64 -q -o furnace.exr --png furnace.png
range=$(oiiotool furnace.png --ch R,G,B --printstats | sed -n 's/.*Stats \(Min\|Max\): *\([0-9]*\).*/\2/p' | xargs)
read -r low high <<< "$range"
[ -n "$high" ] && [ $((high - low)) -le 2 ] || { echo "furnace.sh: the png runs from $low to $high against the sky of the file, expected one value" >&2; exit 1; }

# The light of a clear day is bluer than the sun. A wrong sky is refused in one line.
p1solve clumps.vdb --sun 0,1,0 --sun-irradiance 1,1,1 --sky day -q --json day.json -o day.vdb
p1solve clumps.vdb --sun 0,1,0 --sun-irradiance 1,1,1 --sky 0 -q --json night.json -o night.vdb
sky_in() { sed -n 's/.*"sky_in": *\([0-9.e-]*\).*/\1/p' "$1" | xargs; }
read -r blue green red <<< "$(sky_in day.json)"
awk -v r="$red" -v g="$green" -v b="$blue" 'BEGIN {exit !(r > 0 && g > r && b > g)}' || { echo "furnace.sh: --sky day gives $red $green $blue of light, expected red < green < blue" >&2; exit 1; }
[ "$(sky_in night.json)" = "0.0 0.0 0.0" ] || { echo "furnace.sh: --sky 0 gives light of $(sky_in night.json), expected 0.0" >&2; exit 1; }
for wrong in "--sky blue" "--sky -1" "--sky 1,2" "--sky-zenith -1"; do
    status=0
    p1solve clumps.vdb $wrong -q -o x.vdb 2> said || status=$?
    [ "$status" = 2 ] && [ "$(wc -l < said)" = 1 ] && [ ! -e x.vdb ] || { echo "furnace.sh: p1solve $wrong: status $status, $(cat said)" >&2; exit 1; }
done
