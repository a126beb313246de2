#!/usr/bin/env bash
# Time and memory against grid size: each stage for one cumulus at 64^3 to 512^3, one thread. Processor seconds are medians
# of three runs, at 512^3 those of one; memory is what a program holds at its peak beyond that of a cloud of 16^3.
# Usage: scaling.sh BIN [RESOLUTION]. With SIZES="64 128" for those alone.
set -euo pipefail
bin=$(realpath "$1") resolution=${2:-512} sizes=${SIZES:-64 128 256 512}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
# once PROGRAM ARGUMENTS: "seconds bytes"
once() {
    "$bin/$1" "${@:2}" -q --threads 1 --json j.json > /dev/null 2>&1
    awk '/^  "cpu_seconds"/ { s = $2 } /^  "peak_memory_bytes"/ { b = $2 } END { print s + 0, b + 0 }' j.json
}
# measured SIZE PROGRAM ARGUMENTS: the same of the run that takes the median time
measured() {
    local runs=3
    [ "$1" != 512 ] || runs=1
    for ((k = 0; k < runs; ++k)); do once "${@:2}"; done | sort -g | sed -n $((runs / 2 + 1))p
}
sun=(--sun 0.3,1,0.2) medium=(--extinction 11 --albedo 0.999)
sweeps=(--iterations 3 --reentry-rays 0 --change 1e-9)
density() { once fractalgen --seed 7 --size "$1" -o d.vdb > /dev/null; once illuminate d.vdb "${medium[@]}" "${sun[@]}" --error-samples 0 -o l.vdb > /dev/null; }
density 16
base_p1=$(once p1solve l.vdb --reentry-rays 0 -o s.vdb) base_render=$(once render l.vdb --resolution "$resolution" -o p.exr)

echo "| grid | active voxels | fractalgen | illuminate | render, scattered once | p1solve, P1 | p1solve, three sweeps | render, many times | all of many times |"
echo "|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
for size in $sizes; do
    f=$(measured $size fractalgen --seed 7 --size $size -o d.vdb)
    i=$(measured $size illuminate d.vdb "${medium[@]}" "${sun[@]}" --error-samples 0 -o l.vdb)
    voxels=$(sed -n 's/.*"active_voxels": *\([0-9]*\).*/\1/p' <("$bin/illuminate" d.vdb --dry-run --json - -o x.vdb 2> /dev/null) | head -n 1)
    r=$(measured $size render l.vdb --resolution "$resolution" -o p.exr)
    p=$(measured $size p1solve l.vdb --reentry-rays 0 -o s.vdb)
    s=$(measured $size p1solve l.vdb "${sweeps[@]}" -o s.vdb)
    m=$(measured $size render s.vdb --resolution "$resolution" -o p.exr)
    echo "$size $voxels $f $i $r $p $s $m" >> rows
    awk '{ printf "| %d^3 | %d | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.1f |\n", $1, $2, $3, $5, $7, $9, $11, $13, $3 + $5 + $11 + $13 }' <(tail -n 1 rows)
done
echo
echo "Nanoseconds and bytes an active voxel:"
echo
echo "| grid | fractalgen | illuminate | P1 | three sweeps | P1 [B] | three sweeps [B] | render, once [B] | many times [B] |"
echo "|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
awk -v p1="${base_p1#* }" -v render="${base_render#* }" '{
    v = $2
    printf "| %d^3 | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f | %.0f |\n", $1, 1e9 * $3 / v, 1e9 * $5 / v, 1e9 * $9 / v, 1e9 * $11 / v,
        ($10 - p1) / v, ($12 - p1) / v, ($8 - render) / v, ($14 - render) / v }' rows
echo
echo "What else a scene may ask for, as ratios to three sweeps of one sun, 32 directions and one albedo:"
echo
echo "| grid | albedo .999,.99,.95 | two suns | degree 7, 256 directions | memory: three albedos | two suns | degree 7 |"
echo "|--:|--:|--:|--:|--:|--:|--:|"
for size in $sizes; do
    [ $size -le 256 ] || continue
    density $size
    read -r of held < <(once p1solve l.vdb "${sweeps[@]}" -o s.vdb)
    c=$(once p1solve l.vdb --albedo 0.999,0.99,0.95 "${sweeps[@]}" -o s.vdb)
    t=$(once p1solve d.vdb "${medium[@]}" "${sun[@]}" --sun -0.5,0.6,0.3 "${sweeps[@]}" -o s.vdb)
    d=$(once p1solve l.vdb "${sweeps[@]}" --degree 7 --directions 256 -o s.vdb)
    awk -v n=$size -v of="$of" -v held="$held" -v c="$c" -v t="$t" -v d="$d" 'BEGIN {
        split(c, C); split(t, T); split(d, D)
        printf "| %d^3 | %.2f | %.2f | %.1f | %.2f | %.2f | %.1f |\n", n, C[1] / of, T[1] / of, D[1] / of, C[2] / held, T[2] / held, D[2] / held }'
done
