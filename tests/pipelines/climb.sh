#!/usr/bin/env bash
# make ERROR=2%: the rung at which the climb stops, what it makes again, what it says when the time ends, and that no word runs
# anything. Programs that write what this test wants stand for ours; then one climb by ours.
# Usage: climb.sh BIN
set -Eeuo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trap 'echo "climb.sh: line $LINENO failed: $(cat said)" >&2' ERR
fail() { echo "climb.sh: $*" >&2; exit 1; }
unset MAKELEVEL MAKEFLAGS MFLAGS TIME
mkdir "$folder/fake"
cd "$folder"

# A program that writes its name, the rung and how often it ran. render also writes a report: error and interval [%] of a rung stand
# in the file `errors`, as "rung value half-width reliable".
cat > fake/program <<'FAKE'
#!/usr/bin/env bash
set -eu
[ "${1:-}" != --help ] || { echo --certify; exit 0; }
case " $* " in *" --print-scene "*) exit 0;; esac
name=$(basename "$0") rung= out= png= json= certify=
echo "$name $*" >> "$FAKE/calls"
while [ $# -gt 0 ]; do
    case $1 in
    --rung) rung=$2; shift;; -o) out=$2; shift;; --png) png=$2; shift;; --json) json=$2; shift;; --certify) certify=$2; shift;;
    esac
    shift
done
echo "$name $rung" > "$out"
[ -z "$png" ] || echo "picture of rung $rung" > "$png"
[ "$name" = render ] && [ -n "$json" ] || exit 0
[ ! -e "$FAKE/sleep" ] || [ "$rung" = 0 ] || sleep "$(cat "$FAKE/sleep")"
if [ -z "$certify" ]; then echo '{ "accuracy": { "noise": 0.09 } }' | sed 's/[{,] */&\n/g' > "$json"; exit 0; fi
# Longer certificates are narrower.
awk -v rung="$rung" -v s="${certify#*,}" '$1 == rung {
    half = $3 * sqrt(2 / s)
    printf "{\n \"certificate\": {\n  \"reliable\": %s,\n  \"rms_32x32\": {\n   \"high\": %g,\n   \"low\": %g,\n   \"value\": %g\n  }\n }\n}\n",
        (s > $5 ? "true" : "false"), ($2 + half) / 100, ($2 - half) / 100, $2 / 100 }' "$FAKE/errors" > "$json"
[ "$certify" != x ] && awk -v rung="$rung" '$1 == rung { exit $4 }' "$FAKE/errors"
FAKE
chmod +x fake/program
for name in fractalgen illuminate p1solve render; do ln -s program "fake/$name"; done
export FAKE=$folder/fake
# rung, error, half-width after two seconds, status of the certificate, seconds from which it can be relied on.
printf '%s\n' '0 80 3 0 0' '1 20 1 0 0' '2 4 1 3 0' '3 1.9 0.8 0 0' '4 1.0 0.3 0 0' '5 0.5 0.1 0 5' > fake/errors
climb() { make -s --no-print-directory -C "$top/pipelines/cumulus" BIN="$FAKE" OUT="$folder/out" "$@" < /dev/null > said 2>&1; }
calls() { grep -c "^$1" fake/calls || true; }
expect() { # WHAT FILE: said has the line
    grep -qF -- "$1" said || fail "expected '$1' in: $(cat said)"
}

# The first rung whose interval ends below the bound: rung 3 with 1.9 +- 0.8 % may hold 2 %, and does not.
climb ERROR=2%
expect 'cumulus: rung 4 holds 2%'
expect "$folder/out/cumulus.png"
expect '4 % to 1.9 % for'
[ "$(cat out/cumulus.png)" = 'picture of rung 4' ] || fail "not the picture of rung 4: $(cat out/cumulus.png)"
[ "$(awk '$1 ~ /^[0-4]$/' said | wc -l)" = 5 ] || fail "expected five tries: $(cat said)"
[ "$(calls p1solve)" = 4 ] || fail "expected four solves: $(cat fake/calls)"
# A certificate that does not decide takes twice the time: 3 % at two seconds may hold for rung 2, and does not hold for four.
[ "$(grep -c 'render.*--rung 2 .*--certify' fake/calls)" = 1 ] || fail "rung 2, whose error is 4 +- 1 %, was measured twice"
[ "$(grep -c 'render.*--rung 3 .*--certify' fake/calls)" -ge 2 ] || fail "rung 3, which may hold 2 %, was not measured again"

# The same again makes nothing; another bound goes on from there.
before=$(wc -l < fake/calls)
climb ERROR=2%
[ "$(wc -l < fake/calls)" = "$before" ] || fail "the same again runs a program: $(tail -n 1 fake/calls)"
climb ERROR=6%
expect 'cumulus: rung 2 holds 6%'
[ "$(cat out/cumulus.png)" = 'picture of rung 2' ] || fail "not the picture of rung 2"
climb ERROR=0.75%
expect 'cumulus: rung 5 holds 0.75%'
[ "$(grep -c 'render.*--rung 5 .*--certify' fake/calls)" -ge 2 ] || fail "an interval that cannot be relied on ended the climb"
[ "$(calls p1solve)" = 5 ] || fail "expected one more solve"

# Whole light paths: their noise is the certificate.
climb ERROR=0.4%
expect 'cumulus: rung 6 holds 0.4%'
grep -q 'render.*--rung 6 .*--noise 0.096 --time-limit' fake/calls || fail "rung 6: $(grep 'rung 6' fake/calls)"
! climb ERROR=0.2% || fail "noise of 0.09 a pixel cannot hold 0.2 %"
expect 'no rung holds 0.2% in 600 s'
expect 'Error 3'
[ "$(cat out/cumulus.png)" = 'picture of rung 6' ] || fail "a climb that failed took the picture away"

# The time ends within a try: status 3, and the best picture is named.
rm -rf out
echo 8 > fake/sleep
! climb ERROR=2% TIME=4 || fail "expected no end in four seconds"
expect 'the time ended on rung 1; the best picture is'
expect 'out/rung0/cumulus.png'
expect 'Error 3'
rm fake/sleep
climb ERROR=30% TIME=60
expect 'cumulus: rung 1 holds 30%'

# A rung beats a bound of the error, and a film needs one rung.
climb ERROR=2% RUNG=1
! grep -q 'at most' said || fail "RUNG=1 ERROR=2% climbs"
[ "$(cat out/cumulus.png)" = 'picture of rung 1' ] || fail "RUNG=1: $(cat out/cumulus.png)"
! make -s -C "$top/pipelines/cumulus-growth" BIN="$FAKE" OUT="$folder/film" ERROR=2% > said 2>&1 || fail "a film climbs"
expect 'a film needs one for all: give RUNG'
# What make only lists runs nothing.
before=$(wc -l < fake/calls)
climb -n ERROR=1%
[ "$(wc -l < fake/calls)" = "$before" ] || fail "make -n runs a program"

# The sky that lights a pipeline's medium reaches each rung: p1solve and render read the scene.
for pipeline in fractal-cumulus sunset multiple-scattering; do
    grep -q "^\[sky\]" "$top/pipelines/$pipeline/scene.toml" || fail "$pipeline has no sky"
    for rung in 0 2 6; do
        make -n -C "$top/pipelines/$pipeline" BIN="$FAKE" OUT="$folder/sky$rung" RUNG=$rung VDBCLOUD_REAL= > said 2>&1 || fail "$(cat said)"
        reads=render
        [ $rung != 2 ] || reads=p1solve
        grep -q "/$reads .*--scene scene.toml .*--rung $rung" said || fail "$pipeline on rung $rung: no sky for $reads: $(cat said)"
    done
done
# A pipeline whose pictures are put together climbs for each part that has rungs, and in an empty folder, too.
make -n -C "$top/pipelines/multiple-scattering" BIN="$FAKE" OUT="$folder/both" ERROR=2% VDBCLOUD_REAL= > said 2>&1 || fail "$(cat said)"
[ "$(grep -c 'climb.sh .* cumulus ' said)" = 1 ] || fail "expected a climb for cumulus.png"
[ "$(grep -c 'climb.sh' said)" = 1 ] || fail "a picture that is put together climbs"
expect '--mosaic'

for wrong in 5 'x%' '0%' '' '-1%' '$(shell touch ran)%' "5%'; touch ran; '" '`touch ran`%' '5%;touch ran'; do
    [ -z "$wrong" ] || ! climb ERROR="$wrong" || fail "ERROR='$wrong': expected a refusal"
    [ -z "$wrong" ] || expect "ERROR = '$wrong'"
done
for wrong in x 0 '$(shell touch ran)' '`touch ran`' '5; touch ran'; do
    ! climb ERROR=5% TIME="$wrong" || fail "TIME='$wrong': expected a refusal"
    expect "TIME = '$wrong'"
done
[ -z "$(find "$folder" "$top/pipelines" -name ran)" ] || fail "a word ran a command"

# Ours, if render measures errors: the rung that holds errs by less than what was asked for.
"$bin/render" --help | grep -e '--certify' > /dev/null || { echo "skipped: a climb by our programs, whose render has no --certify"; exit 0; }
make -s --no-print-directory -C "$top/pipelines/cumulus" PICTURE=small BIN="$bin" OUT="$folder/ours" render_flags='--resolution 64x64' \
    ERROR=10% TIME=200 > said 2>&1 || fail "$(cat said)"
expect 'holds 10%'
rung=$(sed -n 's/.*rung \([0-9]\) holds.*/\1/p' said)
[ "$rung" -ge 1 ] || fail "light scattered once cannot hold 10 %: $(cat said)"
cmp -s "ours/cumulus.png" "ours/rung$rung/cumulus.png" || fail "not the picture of the rung that holds"
