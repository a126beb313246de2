#!/usr/bin/env bash
# What further colours cost p1solve: processor seconds and memory of one and of three albedos (medians of three alternate
# runs, one thread), and, by `perf`, which parts of a run a further colour repeats. The cumulus of scaling.sh.
# Usage: colours.sh BIN [SIZE]
set -euo pipefail
bin=$(realpath "$1") size=${2:-256}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$bin/fractalgen" -q --seed 7 --size "$size" -o d.vdb
"$bin/illuminate" -q d.vdb --extinction 11 --albedo 0.999 --sun 0.3,1,0.2 --error-samples 0 -o l.vdb
grey=0.999 colours=0.999,0.99,0.95
solve() { "$@" "$bin/p1solve" l.vdb -q --threads 1 --iterations 3 --reentry-rays 0 --change 1e-9 --albedo "$albedo" --json j.json -o s.vdb > perf.log 2>&1; }
for ((k = 0; k < 3; ++k)); do
    for albedo in $grey $colours; do
        solve env
        awk '/^  "cpu_seconds"/ { s = $2 } /^  "peak_memory_bytes"/ { b = $2 } /"active_voxels"/ && !v { v = $2 } END { print s + 0, b + 0, v + 0 }' j.json >> "$albedo.runs"
    done
done
for albedo in $grey $colours; do
    sort -g "$albedo.runs" | sed -n 2p
done | awk -v n="$size" '
    BEGIN { print "| grid | albedo .999 [s] | .999,.99,.95 [s] | ratio | memory [MB] | [MB] |\n|--:|--:|--:|--:|--:|--:|" }
    { s[NR] = $1; b[NR] = $2 / 1e6 }
    END { printf "| %d^3 | %.2f | %.2f | %.2f | %.0f | %.0f |\n", n, s[1], s[2], s[2] / s[1], b[1], b[2] }'
command -v perf > /dev/null || { echo "colours.sh: no perf, so no parts" >&2; exit 0; }
for albedo in $grey $colours; do
    solve perf record -F 500 -o "$albedo.perf"
    perf report -i "$albedo.perf" --no-children -F sample,sym --stdio 2> /dev/null | awk -v a="$albedo" '
        /^#/ || NF < 2 { next }
        {
            part = "files, beams, all else"
            if (/sweep_(one|two|three|planes)/) part = "sweeps: characteristics"
            else if (/block_sweep::(accumulate|expand|fetch)|Impl::clear_inactive/) part = "sweeps: moments and sources"
            else if (/Aprons|VoidRays|VoidBeam|take_region|find_lit|leave_face|block_sweep::leave/) part = "sweeps: between blocks"
            else if (/FaceTallies|PlaneTallies|block_sweep::(pad|add)/) part = "sweeps: faces and planes"
            else if (/smooth|restrict|apply|advance|FinestLevel|GraphLevel|conjugate|dot_block|add_block|Multigrid|collapsed|grouped|joined|group_block|pair_up|strongest|inverse_diagonal|DenseFactor|take_flux|solve_p1|add_fields|clear_inactive<double>|P1Operator::P1Operator/) part = "solver"
            else if (/lower_fluxes|cross_gradients|add_fluxes|close_face|SecondMoment|Mixing/) part = "balance of cells, mixing"
            else if (/\[k\]|memset|memmove|memcpy/) part = "new memory, copies"
            n[part] += $1
        }
        END { for (p in n) printf "%s\t%s\t%.3f\n", a, p, n[p] / 500 }'
done | awk -F '\t' -v grey=$grey '
    { if ($1 == grey) { one[$2] = $3; of += $3 } else three[$2] = $3; parts[$2] }
    END {
        print "\n| part | one albedo [s] | three [s] | a further one, of its first [%] | of all of one [%] |\n|---|--:|--:|--:|--:|"
        for (p in parts) {
            more = (three[p] - one[p]) / 2
            printf "| %s | %.2f | %.2f | %.0f | %.1f |\n", p, one[p], three[p], (one[p] > 0 ? 100 * more / one[p] : 0), 100 * more / of
        }
    }' | (read -r blank; echo; read -r head; echo "$head"; read -r line; echo "$line"; sort)
