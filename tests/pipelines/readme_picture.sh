#!/usr/bin/env bash
# The picture of README's first screen is the one that `make -C pipelines` makes, by the part of it that holds cloud, wisps, sky, sea and shadow.
# Usage: readme_picture.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
make -s -C "$top/pipelines/fractal-cumulus" BIN="$bin" OUT="$folder" render_flags='--crop 300,330,560,510'
oiiotool "$top/docs/images/fractal-cumulus.png" --cut 260x180+300+330 -o "$folder/part.png"
idiff -fail 0.01 -warn 0.01 "$folder/fractal-cumulus.png" "$folder/part.png"
