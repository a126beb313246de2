#!/usr/bin/env bash
# Cost of each effect of cloudsim, on and off, at N^3 cells: processor time of a cell-step and peak memory of the process. A
# time is the difference of runs of 10 and of 2 steps of 1 s, which cancels start and output; the least of three counts.
# Usage: effects.sh BIN [N]
set -euo pipefail
bin=$1 n=${2:-96}
shape=$n sponge=0
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
value() { sed -n "s/.*\"$1\": *\([0-9.e+]*\).*/\1/p" "$folder/j.json" | head -n 1; }
simulate() {
    local seconds=$1
    shift
    "$bin/cloudsim" --cells "$shape" --dt 1 --minutes "$(awk "BEGIN {printf \"%.6f\", $seconds / 60}")" --every "${seconds}s" --threads 1 \
        --no-forcing --bubble 2000,2000,900,700,500,2,4e-3 --sponge "$sponge" --grids density -o "$folder/f.vdb" --json "$folder/j.json" \
        -q --force "$@" > "$folder/said" 2>&1 || { cat "$folder/said" >&2; exit 1; }
}
row() {
    local name=$1 least=1e9
    shift
    for _ in 1 2 3; do
        simulate 2 "$@"
        local start steps
        start=$(value cpu_seconds) steps=$(value steps)
        simulate 10 "$@"
        least=$(awk -v a="$start" -v b="$(value cpu_seconds)" -v n="$(($(value steps) - steps))" -v l="$least" \
            'BEGIN {t = (b - a) / n; print (t < l ? t : l)}')
    done
    cells=$(value cells)
    awk -v name="$name" -v t="$least" -v c="$cells" -v m="$(value peak_memory_bytes)" -v f="$(value field_bytes)" \
        'BEGIN {printf "| %s | %.0f | %.0f | %.0f | %.0f |\n", name, 1e9 * t / c, 1e3 * t, f / c, m / 1e6}'
}
echo "| $n^3 cells, one thread | ns a cell-step | ms a step | bytes a cell | peak MB of the process |"
echo "|---|--:|--:|--:|--:|"
row "default"
row "moisture off" --moisture off
row "latent heat off" --latent-heat off
row "saturation by height" --saturation height
row "vapour and loading off" --vapour off --loading off
row "buoyancy and moisture off" --buoyancy off --moisture off
row "wind given, dye only" --momentum off --buoyancy off --moisture off --dye on
shape=$((10 * n)),1,$((10 * n))
row "one cell wide, ten times as long"
shape=$n
row "dye on" --dye on
row "rain on" --rain on
row "sources on" --source 'sphere; at=0,900,0; radius=500; heat=1e-4'
row "a collider, a ball" --collider 'sphere; at=0,900,0; radius=500'
row "a box that moves" --frame-velocity wind
row "moisture off; dye, combustion, cooling, buoyancy of hot gas on" --moisture off --dye on --combustion on --hot-buoyancy on --cooling 2500
row "friction on" --friction-time 1000
row "viscosity and diffusion on" --viscosity 1 --diffusivity 1
row "sub-grid mixing on" --subgrid on
row "radiation on" --radiation 70
sponge=0.02
row "sponge on"
sponge=0
row "wind relaxation on" --wind-relaxation 1000
row "anelastic on" --anelastic on
row "surface stress, Coriolis force, subsidence and tendencies on" --friction-velocity 0.3 --coriolis 1e-4 --forcing bomex
row "double" --precision double
row "--accuracy small" --accuracy small
