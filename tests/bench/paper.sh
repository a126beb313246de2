#!/usr/bin/env bash
# The pictures of Kajiya and Von Herzen 1984, at their sizes, in processor seconds of all stages: light scattered once, as its pass one and
# two have it, and many times, by p1solve with two sweeps. A table for docs/paper.md, on standard output.
# Usage: paper.sh BIN [FOLDER]: the pictures stay in FOLDER.
set -euo pipefail
bin=$(cd "$1" && pwd)
if [ -n "${2:-}" ]; then mkdir -p "$2" && folder=$(cd "$2" && pwd); else folder=$(mktemp -d) && trap 'rm -rf "$folder"' EXIT; fi
cd "$folder"
TIMEFORMAT='%U %S'
# spent PROGRAM...: adds the processor seconds of a command to `seconds`.
seconds=0
spent() {
    local took
    took=$({ time "$bin/$1" -q "${@:2}" 2> log; } 2>&1) || { cat log >&2; exit 1; }
    seconds=$(awk -v so_far="$seconds" '{ print so_far + $1 + $2 }' <<< "$took")
}
medium=(--extinction 40 --albedo 0.99 --g 0.6)
sky=(--sky-zenith 0.011,0.026,0.06 --sky-horizon 0.055,0.075,0.1 --sky-ground 0.03,0.03,0.026)
# row NAME PIXELS MEDIUM... -- RENDER...: the picture of NAME.vdb both ways, after `seconds` for its density.
row() {
    local name=$1 pixels=$2 density=$seconds once many light
    shift 2
    spent illuminate "$name.vdb" --sun=-0.8,0.5,0.5 --sun-irradiance 1,0.93,0.82 "$1" "$2" "$3" "$4" "$5" "$6" -o "$name.light.vdb"
    shift 6
    light=$seconds
    spent render "$name.light.vdb" "${sky[@]}" --resolution "$pixels" "$@" -o "$name.once.exr" --png "$name.once.png"
    once=$seconds seconds=$light
    spent p1solve "$name.light.vdb" "${sky[@]}" --iterations 2 -o "$name.lit.vdb"
    spent render "$name.lit.vdb" --resolution "$pixels" "$@" -o "$name.many.exr" --png "$name.many.png"
    many=$seconds seconds=0
    printf '| %s | %s | %.1f | %.1f | %.1f |\n' "$title" "$pixels" "$density" "$once" "$many"
}

echo "| picture | pixels | density [s] | scattered once [s] | many times [s] |"
echo "|---|---|---|---|---|"
title="cloud and mountain, 64x32x64"
spent fractalgen --mountain --seed 3 --size 128 --bounds=-1,0,-1,1,0.9,1 --relief 0.4 -o mountain.vdb
spent fractalgen mountain.vdb --seed 5 --size 64 --bounds=-0.9,0.2,-0.1,0.9,0.75,1 --envelope slab --coverage 0.45 --roughness 0.05 --edge 0.03 -o both.vdb
row both 256x256 "${medium[@]}" --camera 0,0.75,3 --look-at 0,0.36,0 --fov 40
for size in 16,16,16 32,16,32 64,16,64 128,16,128; do
    name=c${size//,/x} title="fractal cloud, ${size//,/x}"
    spent fractalgen --seed 7 --size "$size" --roughness 0.03 -o "$name.vdb"
    row "$name" 512x512 "${medium[@]}"
done
title="simulated cloud, 10x20x10"
spent cloudsim --preset paper --every 10min --minutes 20 --grids density -o 'paper.%04d.vdb'
last=$(ls paper.????.vdb | tail -1)
cp "$last" paper.vdb
row paper 512x512 --phase henyey-greenstein --albedo 0.99 --g 0.6
