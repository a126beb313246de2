#!/usr/bin/env bash
# The rule of pipelines/rules.mk for light paths: parts made by separate jobs and merged are the picture of one run.
# Usage: parts.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

make -s -C "$top/pipelines/cumulus" PICTURE=small BIN="$bin" OUT="$folder" SPP=3 PARTS=3 "$folder/cumulus.path.exr"
[ "$(ls "$folder"/cumulus.part?.exr | wc -l)" = 3 ] || { echo "parts.sh: expected 3 parts" >&2; exit 1; }
"$bin/render" -q "$folder/cumulus.light.vdb" --scene "$top/pipelines/cumulus/scene.toml" --resolution 128x128 \
    --integrator path --spp 9 --aov standard_error -o "$folder/whole.exr"
idiff -fail 1e-4 -warn 1e-4 "$folder/whole.exr" "$folder/cumulus.path.exr"

# A pipeline whose scene sets what the .png alone shows.
make -s -C "$top/pipelines/multiple-scattering" PICTURE=small render_flags='--resolution 16x16' density_flags='--size 24' BIN="$bin" \
    OUT="$folder/many" SPP=1 PARTS=2 "$folder/many/cumulus.path.exr"
[ -s "$folder/many/cumulus.part1.png" ] || { echo "parts.sh: a part has no .png" >&2; exit 1; }
