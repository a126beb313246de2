#!/usr/bin/env bash
# The picture of README's first screen is the one that `make -C pipelines` makes.
# Usage: readme_picture.sh BIN
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
make -s -C "$top/pipelines/fractal-cumulus" BIN="$bin" OUT="$folder"
idiff -fail 0.01 -warn 0.01 "$folder/fractal-cumulus.png" "$top/docs/images/fractal-cumulus.png"
