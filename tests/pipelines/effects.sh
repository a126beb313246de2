#!/usr/bin/env bash
# Every pipeline's scene at a small size: with all effects forced the picture is that of the effects that the programs choose, within
# the 2 % of --accuracy-error, rms over the mean of the picture.
# Usage: effects.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "effects.sh: $*" >&2; exit 1; }

# chain NAME SCENE OPTION ...: cloud.vdb through the chain, to NAME.exr.
chain() {
    local name=$1 scene=$2
    shift 2
    "$bin/illuminate" -q cloud.vdb --scene "$scene" "${solid[@]}" "$@" -o light.vdb
    "$bin/p1solve" -q light.vdb --scene "$scene" "$@" --iterations 1 -o solved.vdb
    "$bin/render" -q solved.vdb --scene "$scene" "${frame[@]}" "$@" --resolution 24x16 --samples 1 --aov none --background none -o "$name.exr"
}

"$bin/fractalgen" -q --mountain --size 16 -o mountain.vdb
scenes=0 seen=0 known=
for scene in "$top"/pipelines/*/scene*.toml; do
    # Scenes that say the same are one.
    text=$(grep -v "^#" "$scene" | tr -d " \n")
    case "$known" in *"|$text|"*) continue ;; esac
    known+="|$text|"
    pipeline=$(basename "$(dirname "$scene")") solid=() frame=() config=()
    ! [ -e "$(dirname "$scene")/density.toml" ] || config=(--config "$(dirname "$scene")/density.toml")
    # Its own density is simulated; a period is of whole blocks.
    [ "$pipeline" != les ] || config=(--config "$top/pipelines/stratocumulus/density.toml")
    [ "$pipeline" != cloud-and-mountain ] || solid=(--solid mountain.vdb)
    # A camera that stands for another cloud may look past this one.
    [ -n "${config[*]}" ] || frame=(--look-at 0,0.4,0)
    "$bin/fractalgen" -q "${config[@]}" --size 16 -o cloud.vdb
    chain auto "$scene"
    chain all "$scene" --effects all
    # A mean, and an error of the difference.
    read -r mean rms < <({ oiiotool --stats auto.exr all.exr --diff --fail 0 || true; } |
        awk '/Stats Avg/ && !n++ { mean = ($3 + $4 + $5) / 3 } /RMS error/ { rms = $4 } /^PASS|RMS error/ { compared = 1 }
            END { if (compared) print mean, rms + 0 }')
    awk -v rms="${rms:-0}" -v mean="$mean" 'BEGIN { exit !(rms <= 0.02 * mean) }' ||
        fail "$pipeline: all effects change the picture by $rms, of a mean of $mean"
    scenes=$((scenes + 1))
    awk -v mean="$mean" 'BEGIN { exit !(mean > 1e-6) }' && seen=$((seen + 1))
done
[ "$seen" -ge 8 ] || fail "of $scenes scenes $seen show anything: expected 8 or more"

# A pipeline runs p1solve only where the effects of its scene need it.
mkdir -p tree/pipelines/one out
cp "$top/pipelines/rules.mk" tree/pipelines
cp -r "$top/cmake" "$top/data" tree
printf 'scattering := yes\n.PHONY: all\nall:\ninclude ../rules.mk\nall: $(OUT)/cloud.exr\n' > tree/pipelines/one/Makefile
cp cloud.vdb out/cloud.density.vdb
for effects in lights lights,multiple; do
    printf '[picture]\nresolution = "8"\n[accuracy]\neffects = "%s"\n' "$effects" > tree/pipelines/one/scene.toml
    env -u MAKELEVEL -u MAKEFLAGS -u MFLAGS make -s -C tree/pipelines/one BIN="$bin" OUT="$folder/out" > said 2>&1 || { cat said >&2; fail "no picture of $effects"; }
    solved=$([ -e out/cloud.scatter.vdb ] && echo yes || echo no)
    [ "$solved" = "$([ "$effects" = lights ] && echo no || echo yes)" ] || fail "effects $effects: p1solve ran: $solved"
done
echo "effects.sh: $scenes scenes, $seen of them with something to see"
