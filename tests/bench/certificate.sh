#!/usr/bin/env bash
# What it costs to know a picture's error: README's cumulus with multiple scattering, 512 x 512 pixels, until the error over 32 x 32
# pixels is known to 0.5 % at g = 0 and to 1 % at g = 0.85. Processor seconds; the ratio is that to all stages before.
# Usage: certificate.sh BIN [SIZE]
set -euo pipefail
bin=$(cd "$1" && pwd)
size=${2:-256}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
# number NAME FILE: of a report. interval NAME FILE: its value, low and high.
number() { sed -n "s/^ *\"$1\": \([-0-9.e+]*\),\{0,1\}$/\1/p" "$2" | tail -1; }
interval() {
    sed -n "/\"$1\": {/,/}/p" "$2" > interval.json
    for end in value low high; do number "$end" interval.json; done | xargs
}
"$bin/fractalgen" -q --size "$size" --seed 7 -o cloud.vdb
echo "| g | illuminate, p1solve, render [s] | asked | error over 32x32 pixels | mean | samples | certificate [s] | ratio |"
echo "|--:|--:|--:|--:|--:|--:|--:|--:|"
for row in "0 0.5" "0.85 1"; do
    read -r g asked <<< "$row"
    "$bin/illuminate" -q cloud.vdb --albedo 0.999 --g "$g" --sun 0.3,1,0.2 -o lit.vdb --json illuminate.json
    "$bin/p1solve" -q lit.vdb --iterations 3 -o solved.vdb --json p1solve.json
    "$bin/render" -q solved.vdb -o plain.exr --json render.json
    "$bin/render" -q solved.vdb --certify "$asked%" -o certified.exr --json certified.json
    for stage in illuminate p1solve render; do sed -n 's/^  "cpu_seconds": \([0-9.e-]*\).*/\1/p' $stage.json; done | xargs > seconds
    sed -n '/"certificate": {/,/^  }/p' certified.json > certificate.json
    echo "$g $(cat seconds) $asked $(interval rms_32x32 certificate.json) $(interval mean certificate.json)" \
        "$(number samples certificate.json) $(number cpu_seconds certificate.json)" |
        awk '{ chain = $2 + $3 + $4; h = $8 - $6 > $6 - $7 ? $8 - $6 : $6 - $7
               printf "| %g | %.1f, %.1f, %.1f | %g %% | %.1f +- %.1f %% | %+.1f +- %.1f %% | %d | %.1f | %.2f |\n", $1, $2, $3, $4, $5,
                   100 * $6, 100 * h, 100 * $9, 100 * ($11 - $9), $12, $13, $13 / chain }'
done
