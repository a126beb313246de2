#!/usr/bin/env bash
# The gallery: pictures with solids from nothing to a page, each with its seconds and its error; and what a second make does.
# Usage: gallery.sh BIN. The page is opened by Chromium where that is installed.
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "gallery.sh: $*" >&2; exit 1; }
pictures="ground-shadow cloud-and-mountain dust"
# Every picture is in the gallery: each has a folder with a scene, and the Disney cloud is skipped by name without its file.
all() { make -n -s -C "$top/pipelines/gallery" BIN="$bin" OUT="$folder/all" VDBCLOUD_REAL="$1" 2> /dev/null; }
mkdir "$folder/real"
all "$folder/real" > "$folder/said" || true
for p in fractal-cumulus sunset cloud-and-mountain mirror-sphere ground-shadow fog-with-spotlight dust stratocumulus campfire cumulus-growth cloud-over-terrain; do
    [ -e "$top/pipelines/$p/scene.toml" ] && grep -q "/$p.png --fit" "$folder/said" || fail "$p is not in the gallery"
done
grep -q "gallery: disney is skipped" "$folder/said" && ! grep -q "/disney.png" "$folder/said" || fail "disney without its file"
touch "$folder/real/wdas_cloud_sixteenth.vdb"
all "$folder/real" > "$folder/said" || true
grep -q "/disney.png --fit" "$folder/said" || fail "disney is not in the gallery, though its file is there"
gallery() { make -s -C "$top/pipelines/gallery" PICTURE=small PICTURES="$pictures" BIN="$bin" OUT="$folder" > "$folder/said" 2> "$folder/progress" || { cat "$folder/progress" >&2; fail "status $?"; }; }
gallery
for p in $pictures; do
    grep -q "<figure id=\"$p\">" "$folder/index.html" || fail "no $p on the page"
    idiff -q -fail 0.02 "$folder/$p/$p.png" "$folder/$p/shown" || fail "$p: another picture is shown"
done
# Errors between two bounds, of pictures of a few thousand pixels: the upper end is not 0, the estimate is not the size of the picture. The
# estimate is 0 where a busy machine leaves the light paths so few samples that their noise hides the error.
sed -n 's/.*<td>error<td>\([^ ]*\) % (\([^ ]*\) to \([^ ]*\))/\1 \2 \3/p' "$folder/index.html" |
    awk '{ ++n; if (!($3 > 0.5 && $1 < 25 && $2 <= $1 && $1 < $3)) { print "gallery.sh: error " $0 > "/dev/stderr"; bad = 1 } } END { exit bad || n != 3 }' ||
    fail "errors are not as expected"
# Effects in play: the dust has coefficients of colour, and all three have solids.
[ "$(grep -c "<td>effects in play<td>.*multiple.*solids" "$folder/index.html")" = 3 ] || fail "effects: expected solids and multiple scattering in three pictures: $(grep effects "$folder/index.html")"
[ "$(grep -c "<td>effects in play<td>.*colour" "$folder/index.html")" = 1 ] || fail "effects: expected colour in one picture: $(grep effects "$folder/index.html")"
# The mountain travels in the file of the light that it shadows.
"$bin/vdbdiff" "$folder/cloud-and-mountain/cloud-and-mountain.light.vdb" "$folder/cloud-and-mountain/cloud-and-mountain.density.vdb" > "$folder/diff" 2>&1 && fail "no solid in the file"
grep -q solid "$folder/diff" || fail "the mountain does not travel in the file"
# Nothing is made twice.
touch "$folder/before"
gallery
[ -z "$(find "$folder" -newer "$folder/before" -name '*.vdb' -o -newer "$folder/before" -name '*.html')" ] || fail "a second make makes things again"
if command -v chromium > /dev/null; then
    sed 's|</body>|<script>addEventListener("load", () => { document.title = "seen " + [...document.images].filter(i => !i.naturalWidth).length + " of " + document.images.length; });</script></body>|' \
        "$folder/index.html" > "$folder/seen.html"
    seen=$(HOME=$folder timeout 100 chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --virtual-time-budget=20000 \
        --user-data-dir="$folder/profile" --dump-dom "file://$folder/seen.html" 2> "$folder/chromium.log" | sed -n 's/.*<title>\(seen [^<]*\)<.*/\1/p')
    [ "$seen" = "seen 0 of 3" ] || fail "Chromium says '$seen': expected three pictures and none missing"
else
    echo "gallery.sh: chromium is not installed: the page was not opened in a browser"
fi
