#!/usr/bin/env bash
# README's picture beside that of Blender's Cycles from the same file, sun, sky and sea, in the same processor seconds: hero.png, hero.md.
# The Makefile calls it. Usage: hero.sh BIN OUT PICTURE. Needs blender, oiiotool and awk.
#
# Seconds are processor time, user and system: of illuminate, p1solve and render for ours, of the rendering without Blender's start for
# Cycles, which has no denoiser here. Cycles takes as many samples as fit, at least 1. Both pictures have one exposure, clipped at 1, sRGB.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
. "$here/../benchmarks/cycles/scene.sh"
bin=$(cd "$1" && pwd) out=$(cd "$2" && pwd)/hero picture=$3
toml=$here/../fractal-cumulus/scene.toml
calc() { awk "BEGIN { printf \"%.6g\", ($1) }"; }
# array KEY FILE: the numbers of the first array of a report that has this key, with commas.
array() { sed -n "/\"$1\": \[/,/\]/{s/^ *\([-0-9.e+]*\),\{0,1\}$/\1/p;/\]/q}" "$2" | paste -sd,; }
# of_scene KEY: a number of the scene.
of_scene() { sed -n "s/^$1 = \([-0-9.e+]*\)$/\1/p" "$toml"; }
made() {
    make -s --no-print-directory -C "$here/../fractal-cumulus" PLACED=1 BIN="$bin" OUT="$out" PICTURE="$picture" RUNG=2 ERROR= \
        climb_flags="--json $out/report.json" "$@" > "$out/said"
}
mkdir -p "$out"
rm -f "$out"/fractal-cumulus.{light,scatter}.vdb "$out"/fractal-cumulus.{exr,png}
made "$out/fractal-cumulus.density.vdb"
TIMEFORMAT='%U %S'
{ time made all; } 2> "$out/seconds"
ours=$(awk 'END { print $1 + $2 }' "$out/seconds")

extinction=$(of_scene extinction)
sun=$(sed -n 's/^sun = \[\(.*\)\]/\1/p' "$toml" | tr -d ' ')
camera=$(sed -n 's/^position = \[\(.*\)\]/\1/p' "$toml" | tr -d ' ')
target=$(sed -n 's/^look-at = \[\(.*\)\]/\1/p' "$toml" | tr -d ' ')
# The voxel's edge is that of the density.
voxels=$(awk "BEGIN { print 2 / $(array voxel_size "$out/report.json" | cut -d, -f1) }")
by_cycles() { cycles "$out/fractal-cumulus.density.vdb" "$voxels" "$(of_scene albedo)" "$(of_scene g)" 1 "$1" "$2" "$out/cycles.exr" "$out/report.json"; }
one=$(by_cycles 1 1)
samples=$(awk "BEGIN { n = int($ours / $one + 0.5); print (n < 1 ? 1 : n) }")
theirs=$one
[ "$samples" = 1 ] || theirs=$(by_cycles "$samples" 2)

scale=$(calc "2 ^ $(of_scene exposure)")
oiiotool "$out/cycles.exr" --ch R,G,B --mulc "$scale" --clamp:min=0:max=1 --colorconvert linear sRGB -d uint8 -o "$out/cycles.png"
oiiotool "$out/fractal-cumulus.png" "$out/cycles.png" --mosaic 2x1 -o "$out/hero.png"
blender=$(blender --version | sed -n 's/^Blender *\([0-9.]*\).*/\1/p;T;q')
cat > "$out/hero.md" << EOF
| picture | processor seconds | samples a pixel |
|---|--:|--:|
| illuminate, p1solve --iterations 3, render | $(printf %.0f "$ours") | 1 |
| Cycles of Blender $blender, no denoiser | $(printf %.0f "$theirs") | $samples |
EOF
mv "$out/hero.png" "$out/hero.md" "$out/.."
