#!/usr/bin/env bash
# Measures data/unit_costs.txt: runs commands that differ in what they do, and finds the costs >= 0 of events with which
# counts times costs come nearest to the processor seconds taken, relative to these (unit_costs.awk). Takes some minutes; run
# it on a quiet machine.
# Usage: unit_costs.sh BIN TABLE [MACHINE]
set -euo pipefail
bin=$(realpath "$1") table=$(realpath "$2") machine=${3:-$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -n 1)}
launch=$(cd "$(dirname "$0")" && pwd)/said_and_taken.sh
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export SAID=${SAID:-$folder/said}
run() { "$launch" "$bin/$1" "${@:2}" -q --threads 1 > log 2>&1 || { cat log >&2; exit 1; }; }

for size in 32 64 128 256; do run fractalgen --seed 7 --size $size -o d$size.vdb; done
run fractalgen --seed 3 --envelope sphere --size 192 -o sphere.vdb
for size in 64 160; do run fractalgen --envelope-from d128.vdb --size $size -o x.vdb; done
run fractalgen --envelope slab --coverage 0.4 --size 256 --bounds -2,0,-2,2,1,2 -o deck.vdb
for factor in 2 3 4; do run fractalgen --detail-from d64.vdb --detail-factor $factor -o x.vdb; done
for size in 48 96 160; do run fractalgen --mountain --size $size -o m.vdb; done

medium=(--extinction 60 --albedo 0.9999 --g 0.85)
for size in 32 64 128 256; do run illuminate d$size.vdb --sun 0.3,1,0.2 "${medium[@]}" -o l$size.vdb; done
run illuminate deck.vdb --sun 0.5,1,0.7 -o deck.light.vdb
run illuminate sphere.vdb --sun 0,1,0 --rays-per-voxel 1 -o x.vdb
run illuminate d64.vdb --sun 0.5,1,0 --sun-diameter 5 -o x.vdb
run illuminate d128.vdb --sun 0.5,1,0 --rays-per-voxel 6 -o x.vdb
for size in 64 128; do run illuminate d$size.vdb --lamp 0.5,3,1 -o x.vdb; done

for size in 32 64 128 256; do run p1solve l$size.vdb --reentry-rays 0 -o s$size.vdb; done
run p1solve l128.vdb --reentry-rays 0 --tolerance 1e-10 -o x.vdb
run p1solve l128.vdb --reentry-rays 0 --rays-per-voxel 6 -o x.vdb
run p1solve d128.vdb "${medium[@]}" --sky 0.2 --reentry-rays 0 -o sky.vdb
run p1solve d128.vdb "${medium[@]}" --sky 0.2 --reentry-rays 100000 -o x.vdb
run p1solve l64.vdb --reentry-rays 1000000 -o x.vdb
run p1solve l128.vdb --sky 0.1,0.2,0.3 -o colours.vdb
run p1solve d128.vdb "${medium[@]}" --lamp 0.5,3,1 --reentry-rays 0 -o lamp.vdb
for directions in 24 128; do run p1solve l128.vdb --reentry-rays 0 --iterations 2 --directions $directions --change 1e-9 -o x.vdb; done
run p1solve l64.vdb --reentry-rays 0 --iterations 6 --directions 24 --change 1e-9 -o x.vdb
run p1solve l64.vdb --reentry-rays 0 --iterations 2 --directions 512 --change 1e-9 -o x.vdb
run p1solve l128.vdb --reentry-rays 0 --iterations 3 --directions 64 --degree 3 --change 1e-9 -o degree.vdb
run p1solve l64.vdb --reentry-rays 0 --iterations 2 --directions 256 --degree 7 --change 1e-9 -o x.vdb
for method in "--series 6" "--series 12" "--series 6 --galerkin" "--solver relaxation --max-iterations 9999" "--ground-albedo 0.4" "--flux-map map.exr" "--limiter levermore-pomraning"; do
    run p1solve l64.vdb --reentry-rays 0 $method -o x.vdb
done
run p1solve l128.vdb --reentry-rays 0 --series 6 --galerkin -o x.vdb

picture=(--aov none --background none)
for size in 64 128 256; do run render l$size.vdb "${picture[@]}" --resolution 256 -o x.exr; done
run render l32.vdb "${picture[@]}" --resolution 16 -o x.exr
run render l32.vdb --aov all --background none --resolution 512 -o x.exr
run render l128.vdb "${picture[@]}" --resolution 512 -o x.exr
for size in 32 64; do run render l$size.vdb "${picture[@]}" --resolution 64 -o x.png; done
run render deck.light.vdb "${picture[@]}" --resolution 256 -o x.exr
run render l128.vdb "${picture[@]}" --parts 2 --resolution 256 -o x.exr
run render l128.vdb "${picture[@]}" --shadow-rays --resolution 64 -o x.exr
for rule in steps romberg; do run render l64.vdb "${picture[@]}" --integrator $rule --resolution 128 -o x.exr; done
run render sky.vdb "${picture[@]}" --resolution 256 -o x.exr
run render s128.vdb "${picture[@]}" --resolution 256 -o x.exr
run render s256.vdb "${picture[@]}" --resolution 256 -o x.exr
run render colours.vdb "${picture[@]}" --resolution 256 -o x.exr
run render degree.vdb "${picture[@]}" --resolution 256 -o x.exr
for resolution in 64 256; do run render lamp.vdb "${picture[@]}" --resolution $resolution -o x.exr; done
for size in 32 64 128; do run render l$size.vdb "${picture[@]}" --integrator path --spp 16 --resolution 64 -o x.exr; done
for size in 32 64; do run render d$size.vdb "${picture[@]}" --integrator path --spp 16 --lamp 0.5,3,1 --extinction 10 --albedo 0.9 --resolution 64 -o x.exr; done
run render d128.vdb "${picture[@]}" --integrator path --spp 16 --sun 0.3,1,0.2 --extinction 5 --albedo 0.9 --resolution 96 -o x.exr

simulation=(--minutes 4 --grids density)
for cells in 8 16 32 48; do run cloudsim "${simulation[@]}" --every 60s --cells $cells -o f.%d.vdb; done
run cloudsim "${simulation[@]}" --every 2s --cells 32 -o f.%d.vdb
run cloudsim "${simulation[@]}" --every 60s --cells 32 --precision double -o f.%d.vdb
run cloudsim "${simulation[@]}" --every 60s --cells 32 --rain on --dye on --subgrid on -o f.%d.vdb
for cells in 24 32; do run cloudsim "${simulation[@]}" --every 60s --cells $cells --collider 'sphere; at=0,600,0; radius=500' -o f.%d.vdb; done
for cells in 16 32; do run cloudsim "${simulation[@]}" --every 60s --cells $cells --huge-dt --dt 4 -o f.%d.vdb; done

for n in 100 400; do
    awk -v n=$n 'BEGIN { for (j = 0; j < n; ++j) { for (i = 0; i < n; ++i) printf "%d ", 1 + (i * j) % 7; print "" } }' > table.txt
    run vdbimport table.txt --cell 10,10,10 -o x.vdb
done

for size in 256 1024; do
    for part in 0 1; do
        "$bin/render" d32.vdb --integrator path --spp 1 --spp-offset $part --resolution $size -q -o part$part.exr
    done
    run exrmerge part0.exr part1.exr -o x.exr
done

awk -v machine="$machine" -f "$(dirname "$launch")/unit_costs.awk" "$SAID" "$table" > new
cp new "$table"
