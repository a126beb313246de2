#!/bin/bash
# The film of the growing cumulus has the same frames, bit for bit, when it is killed twice and continued.
#   film.sh BIN [PICTURE]      PICTURE: small (default) or full
# Takes a minute on a quiet machine: skipped unless SIZE=full or a PICTURE is given.
set -eu
[ "${SIZE:-}" = full ] || [ $# -gt 1 ] || exit 77
bin=$(realpath "$1") picture=${2:-small}
root=$(realpath "$(dirname "$0")/../..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
film() { make -C "$root/pipelines/cumulus-growth" --no-print-directory BIN="$bin" OUT="$work/$1" PICTURE="$picture" > "$work/$1.txt" 2>&1; }

# Kills the whole film, as a power cut would, as soon as `$1` exists.
kill_at() {
    setsid make -C "$root/pipelines/cumulus-growth" BIN="$bin" OUT="$work/killed" PICTURE="$picture" > /dev/null 2>&1 &
    local group=$!
    until [ -e "$1" ]; do
        kill -0 $group 2> /dev/null || { echo "film.sh: the film ended before $1 existed"; exit 1; }
        sleep 0.02
    done
    kill -KILL -- -$group
    wait $group 2> /dev/null || true
}

film whole || { tail -n 5 "$work/whole.txt"; exit 1; }
kill_at "$work/killed/growth.0005.coarse.vdb"    # within the simulation
[ ! -e "$work/killed/growth.simulated" ] || { echo "film.sh: the simulation ended before it was killed"; exit 1; }
kill_at "$work/killed/growth.0003.png"           # within the pictures
[ ! -e "$work/killed/growth.mp4" ] || { echo "film.sh: the film ended before it was killed"; exit 1; }
film killed || { tail -n 5 "$work/killed.txt"; exit 1; }

frames=0
for density in "$work"/whole/*.density.vdb; do
    name=$(basename "$density")
    "$bin/vdbdiff" --quiet "$density" "$work/killed/$name" || { echo "film.sh: $name differs"; exit 1; }
    cmp "${density%.density.vdb}.png" "$work/killed/${name%.density.vdb}.png"
    frames=$((frames + 1))
done
for film in growth paper; do
    cmp "$work/whole/$film.log" "$work/killed/$film.log"
    seconds=$(ffprobe -v error -show_entries format=duration -of csv=p=0 "$work/killed/$film.mp4")
    echo "$film.mp4: $seconds s"
done
# A further run changes no file.
dates() { stat -c '%n %y' "$work"/killed/*.{vdb,png,mp4}; }
before=$(dates)
film killed
diff <(echo "$before") <(dates) || { echo "film.sh: a further run makes files again"; exit 1; }
echo "$frames frames are equal bit for bit"
