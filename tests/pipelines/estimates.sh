#!/usr/bin/env bash
# The commands of the pipelines count as many events as their --dry-run says, within a quarter: pilots have few rays, and
# the solver's iterations are whole numbers of about ten. Counts do not depend on the machine; seconds do and are compared
# by `make -C tests bench`. Memory at the peak is what --dry-run says within 1.3 from 60 MB on.
# Usage: estimates.sh BIN. At SIZE=full with the grids and pictures of the pipelines.
set -euo pipefail
bin=$(realpath "$1") tests=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "estimates.sh: $*" >&2; exit 1; }

export SAID=$folder/said
picture=small
[ "${SIZE:-}" = full ] && picture=full
made() {
    local pipeline=$1
    shift
    local targets=("${@/#/$folder/$pipeline/}")
    make -s -C "$tests/../pipelines/$pipeline" BIN="$bin" OUT="$folder/$pipeline" PICTURE=$picture SPP=4 PARTS=1 \
        LAUNCH="'$tests/bench/said_and_taken.sh'" "${targets[@]}" > "$folder/log" 2>&1 || { cat "$folder/log" >&2; fail "$pipeline"; }
}
made multiple-scattering cumulus.both.png
made cumulus cumulus.path.exr
made ladder with.3.png
made cumulus-growth growth.simulated
# A lamp takes the march of all scenes.
measured() { "$tests/bench/said_and_taken.sh" "$bin/$1" -q "${@:2}" || fail "$*"; }
measured fractalgen --size 48 --seed 7 -o "$folder/lamp.density.vdb"
measured fractalgen --envelope-from "$folder/lamp.density.vdb" --size 64 -o "$folder/masked.vdb"
measured p1solve "$folder/lamp.density.vdb" --lamp 2,2,2 --albedo 0.99 --g 0.85 -o "$folder/lamp.scatter.vdb"
measured render "$folder/lamp.scatter.vdb" --resolution 64 -o "$folder/lamp.exr"
# Methods of P1 beside the usual one, and what they hold.
measured illuminate "$folder/lamp.density.vdb" --sun 0.3,1,0.2 --extinction 40 --albedo 0.99 --g 0.6 -o "$folder/sun.vdb"
k=0
for method in "--iterations 2 --g 0 --albedo 0.999,0.99,0.95" "--series 4" "--series 4 --galerkin --series-raw" "--solver relaxation --max-iterations 9999" "--limiter levermore-pomraning" \
              "--ground-albedo 0.4" "--flux-map $folder/map.exr" "--heating"; do
    measured p1solve "$folder/sun.vdb" $method -o "$folder/method$((k++)).vdb"
done
measured render "$folder/sun.vdb" --integrator romberg --resolution 48 -o "$folder/romberg.exr"
# Tables whose voxels fill little of the blocks that hold them: a tall column, and a sheet.
echo 5 > "$folder/depth.txt"
echo 250000.5 > "$folder/thickness.txt"
echo 0 0 0 1500 1 1500 0.5 > "$folder/sheet.txt"
measured vdbimport "$folder/depth.txt" --thickness "$folder/thickness.txt" --cell 1,1,1 -o "$folder/column.vdb"
measured vdbimport "$folder/sheet.txt" --boxes --cell 1,1,1 -o "$folder/sheet.vdb"
# Specks far from each other: the tables of trees are most of what is held.
awk 'BEGIN { for (i = 0; i < 8; ++i) for (j = 0; j < 8; ++j) for (k = 0; k < 8; ++k) {
    x = 600 * i + 7 * k; y = 600 * j + 13 * i; z = 600 * k + 5 * j; print x, y, z, x + 1, y + 1, z + 1, 0.5 } }' > "$folder/specks.txt"
measured vdbimport "$folder/specks.txt" --boxes --cell 1,1,1 -o "$folder/specks.vdb"
for axes in none y xz; do measured illuminate "$folder/specks.vdb" --sun 0.3,1,0.2 --periodic $axes -o "$folder/specks.$axes.vdb"; done
measured p1solve "$folder/specks.none.vdb" --albedo 0.9 --g 0.6 -o "$folder/specks.scatter.vdb"
measured render "$folder/specks.none.vdb" --resolution 64 -o "$folder/specks.exr"
for part in 0 1; do
    "$bin/render" -q "$folder/lamp.density.vdb" --integrator path --spp 1 --spp-offset $part --resolution 1024 -o "$folder/part$part.exr"
done
measured exrmerge "$folder/part0.exr" "$folder/part1.exr" -o "$folder/both.exr"

# Counts: said over taken of each event that a run counts.
awk '
    # Specks, of which each is solved in one iteration and lit by few rays, are for memory.
    $1 != "event" || $6 == "-" || $3 ~ /^specks/ { next }
    { ratio = $6 > 0 ? $5 / $6 : $5 > 0 ? 1e9 : 1; ++rows[$4] }
    $4 == "p1_relaxation_voxel" && ratio > 0.1 && ratio < 2 { next }  # of theory for a full box
    ratio > 1.25 || ratio < 0.8 { printf "estimates.sh: %s -o %s: %s said %g, taken %g\n", $2, $3, $4, $5, $6; bad = 1 }
    END {
        split("noise_point shape_block mask_point lattice_product light_point beam_voxel p1_setup_voxel p1_iteration_voxel p1_channel_voxel " \
              "p1_relaxation_voxel series_voxel series_node_voxel romberg_point ground_ray ground_face " \
              "sweep_voxel sweep_channel_voxel sweep_moment_voxel closure_voxel outflow_ray ray plain_cell plain_light plain_value plain_peak cell " \
              "cell_light cell_value path_ray path_collision sim_cell table_cell merged_value read_byte write_byte", wanted)
        for (k in wanted) if (!rows[wanted[k]]) { print "estimates.sh: no run counted " wanted[k]; bad = 1 }
        exit bad
    }' "$SAID" >&2 || fail "counts"
# Memory, of programs without a sanitizer.
[ -n "${ASAN_OPTIONS:-}${UBSAN_OPTIONS:-}${TSAN_OPTIONS:-}" ] || awk '
    $1 == "run" && $7 > 6e7 && ($6 / $7 > 1.3 || $6 / $7 < 1 / 1.3) { printf "estimates.sh: %s -o %s: %.0f MB said, %.0f MB taken\n", $2, $3, $6 / 1e6, $7 / 1e6; bad = 1 }
    END { exit bad }' "$SAID" >&2 || fail "memory"
