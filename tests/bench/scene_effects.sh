#!/usr/bin/env bash
# What each effect of a scene costs the program that it costs most: processor seconds and peak memory with the effect absent, present
# and adding nothing, and on. Medians of interleaved runs with one thread; memory is the peak of the process, which differs by a few MB
# between equal runs. "-": there is no such input.
# The second table compares the runs with an idle effect with those without its input.
# Usage: scene_effects.sh BIN [SIZE] [RUNS]
set -euo pipefail
bin=$(cd "$1" && pwd)
size=${2:-192} runs=${3:-3}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$bin/fractalgen" -q --size "$size" --seed 7 -o cloud.vdb
"$bin/fractalgen" -q --size "$size" --seed 8 -o other.vdb

# timed COLUMN TOOL OPTION ...: adds "seconds bytes" of one run to COLUMN.
timed() {
    local column=$1 tool=$2 out=out.vdb
    shift 2
    [ "$tool" != render ] || out=out.exr
    /usr/bin/time -f '%U %S %M' -o spent "$bin/$tool" -q --threads 1 "$@" -o $out
    awk '{ print $1 + $2, 1024 * $3 }' spent >> "$column"
}
median() { sort -g | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'; }
# shown COLUMN: "1.23 s, 210 MB"
shown() {
    [ -e "$1" ] || { echo "-"; return; }
    echo "$(cut -d' ' -f1 "$1" | median) $(cut -d' ' -f2 "$1" | median)" | awk '{ printf "%.2f s, %.0f MB", $1, $2 / 1e6 }'
}
# row NAME TOOL ABSENT IDLE ON: options of three commands; IDLE may be empty.
row() {
    local name=$1 tool=$2
    rm -f absent idle on
    for _ in $(seq "$runs"); do
        # shellcheck disable=SC2086
        timed absent "$tool" $3
        # shellcheck disable=SC2086
        [ -z "$4" ] || timed idle "$tool" $4
        # shellcheck disable=SC2086
        timed on "$tool" $5
    done
    echo "| $name | $tool | $(shown absent) | $(shown idle) | $(shown on) |"
    [ -e idle ] || return 0
    echo "$name $tool $(cut -d' ' -f1 absent | median) $(cut -d' ' -f1 idle | median) $(cut -d' ' -f2 absent | median) $(cut -d' ' -f2 idle | median)" >> ratios
}
light="cloud.vdb --extinction 20 --albedo 0.99 --g 0 --sun 0.3,1,0.2"
solve="$light --iterations 1" picture="$light --resolution 256 --aov none"
dim="--lamp 0,3,0 --lamp-intensity 0" lamp="--lamp 0,3,0 --lamp-intensity 5" solid="--solid sphere;at=0,2.5,0;radius=0.5"
echo "| effect | program | absent | there, adds nothing | on |"
echo "|---|---|--:|--:|--:|"
row lights illuminate "$light" "$light $dim" "$light $lamp"
row lights p1solve "$solve" "$solve $dim" "$solve $lamp"
row lights render "$picture" "$picture $dim" "$picture $lamp"
row sky p1solve "$solve" "$solve --sky 0" "$solve --sky 0.3"
row ground p1solve "$solve" "" "$solve --ground-albedo 0.5"
row solids illuminate "$light" "" "$light $solid"
row solids render "$picture" "" "$picture $solid"
row multiple p1solve "$light --effects lights" "${light/albedo 0.99/albedo 0.001}" "$light"
row multiple render "$picture" "${picture/albedo 0.99/albedo 0.001} --multiple" "$picture --multiple"
row colour illuminate "$light" "" "${light/extinction 20/extinction 18,20,22}"
row colour p1solve "$solve" "" "${solve/albedo 0.99/albedo 0.99,0.98,0.97}"
row colour render "$picture" "" "${picture/extinction 20/extinction 18,20,22}"
row anisotropy p1solve "$solve" "" "${solve/--g 0/--g 0.85}"
row mixture render "$picture" "" "other.vdb $picture"
row periodic illuminate "$light" "" "$light --periodic xz"
# Grids of emission, Cd and temperature in the voxels of the density.
for kind in emission Cd temperature; do
    "$bin/make_fields" cloud.vdb "$kind" idle "$kind.idle.vdb"
    "$bin/make_fields" cloud.vdb "$kind" on "$kind.on.vdb"
done
row emission p1solve "$solve" "emission.idle.vdb ${solve#* }" "emission.on.vdb ${solve#* }"
row emission render "$picture" "emission.idle.vdb ${picture#* }" "emission.on.vdb ${picture#* }"
row fire p1solve "$solve" "temperature.idle.vdb ${solve#* }" "temperature.on.vdb ${solve#* }"
row fire render "$picture" "temperature.idle.vdb ${picture#* }" "temperature.on.vdb ${picture#* }"
row tint p1solve "$solve" "Cd.idle.vdb ${solve#* }" "Cd.on.vdb ${solve#* }"
row tint render "$picture" "Cd.idle.vdb ${picture#* }" "Cd.on.vdb ${picture#* }"
echo
echo "| effect that adds nothing | program | seconds over those without it | memory over that without it |"
echo "|---|---|--:|--:|"
awk '{ printf "| %s | %s | %.3f | %.3f |\n", $1, $2, $4 / $3, $6 / $5 }' ratios
