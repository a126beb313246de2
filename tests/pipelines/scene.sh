#!/usr/bin/env bash
# A change of scene.toml makes again what takes it, and nothing else. `why` says so before. A wrong key makes nothing.
# Usage: scene.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trap 'echo "scene.sh: line $LINENO failed" >&2' ERR
fail() { echo "scene.sh: $*" >&2; exit 1; }
unset MAKELEVEL MAKEFLAGS MFLAGS
mkdir "$folder/pipelines"
cp -r "$top/pipelines/fractal-cumulus" "$top/pipelines/rules.mk" "$folder/pipelines"
rm -rf "$folder/pipelines/fractal-cumulus/out"
cp -r "$top/cmake" "$top/data" "$folder"
cd "$folder/pipelines/fractal-cumulus"
picture() { make -s --no-print-directory BIN="$bin" OUT=out density_flags='--size 24' render_flags='--resolution 24x16' "$@"; }
# Stages that `picture` makes again.
again() {
    touch "$folder/before"
    sleep 0.02
    picture > "$folder/said" 2>&1 || fail "$(cat "$folder/said")"
    find out -newer "$folder/before" \( -name '*.vdb' -o -name '*.exr' \) -printf '%f\n' | sed 's/.*cumulus\.//' | sort | tr '\n' ' '
}
# expect STAGES WHAT: stages that are made again after WHAT.
expect() {
    local found
    found=$(again)
    [ "$found" = "$1" ] || fail "$2: expected '$1' made again, got '$found'"
    [ -z "$(again)" ] || fail "$2, made twice: something is made again"
}
expect 'density.vdb envelope.vdb exr light.vdb scatter.vdb ' 'an empty folder'

sed -i 's/^fov = .*/fov = 44/' scene.toml
why=$(picture why)
grep -q '/render ' <<< "$why" || fail "a change of [camera]: why does not name render: $why"
! grep -qE '/(p1solve|illuminate|fractalgen) ' <<< "$why" || fail "a change of [camera]: why names more than render: $why"
expect 'exr ' 'a change of [camera]'
sed -i 's/^exposure = .*/exposure = 2.9/' scene.toml
expect 'exr ' 'a change of [picture]'
sed -i 's/^zenith = .*/zenith = [0.012, 0.026, 0.06]/' scene.toml
expect 'exr scatter.vdb ' 'a change of [sky]'
sed -i 's/^tolerance = .*/tolerance = 2e-5/' scene.toml
expect 'exr scatter.vdb ' 'a change of the tolerance of p1solve'
sed -i 's/^irradiance = .*/irradiance = [1, 0.9, 0.8]/' scene.toml
expect 'exr light.vdb scatter.vdb ' 'a change of [[lights]]'
sed -i 's/^g = .*/g = 0.8/' scene.toml
expect 'exr light.vdb scatter.vdb ' 'a change of [medium]'
sed -i 's/^fov = .*/fov = 4.4e1 # degrees/; s/^# .*//' scene.toml
touch scene.toml
expect '' 'other comments and forms of numbers'
sed -i 's/^seed = .*/seed = 8/' density.toml
expect 'density.vdb exr light.vdb scatter.vdb ' 'another density'
sed -i 's/^towers = .*/towers = 8/' envelope.toml
expect 'density.vdb envelope.vdb exr light.vdb scatter.vdb ' 'another envelope'

cp scene.toml good.toml
sed -i 's/^fov = .*/fof = 40/' scene.toml
! picture > said 2>&1 || fail "an unknown key: expected a refusal"
grep -q "scene.toml: line [0-9]*: unknown key 'fof' in \[camera\]; did you mean 'fov'?" said || fail "an unknown key: $(cat said)"
cp good.toml scene.toml
expect '' 'the good scene again'
picture RUNG=0 OUT=zero > said 2>&1 || fail "rung 0: $(cat said)"
[ ! -e zero/fractal-cumulus.scatter.vdb ] || fail "rung 0 solves"
