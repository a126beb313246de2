#!/usr/bin/env bash
# From P1 to the transport equation through the programs: what is written, told and refused, and equal runs for any threads.
# Usage: sweeps.sh BIN
set -euo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "sweeps.sh: $*" >&2; exit 1; }
refused() {  # STATUS COMMAND...: ends with that status and one line
    local expected=$1 status=0
    shift
    "$@" > /dev/null 2> said || status=$?
    [ "$status" = "$expected" ] || fail "$*: status $status, expected $expected"
    [ "$(wc -l < said)" = 1 ] || fail "$*: expected one line, got: $(cat said)"
}
fractalgen --size 32 -q -o - | illuminate - --sun 0.3,1,0.2 --extinction 14 -q -o light.vdb
solve="p1solve light.vdb --albedo 0.999 --g 0.85 --reentry-rays 0 -q"

$solve --iterations 6 --directions 40 --degree 3 --threads 1 --json report.json -o one.vdb
$solve --iterations 6 --directions 40 --degree 3 --threads 2 -o two.vdb
vdbdiff one.vdb two.vdb || fail "one thread and two differ"
grep -q '"directions": 64' report.json || fail "40 directions for degree 3 are not reported as 64"
python=$(grep -A12 '"change": \[' report.json | grep -cE '^ *[0-9.e-]+,?$') || true
[ "$python" -ge 3 ] || fail "no history of changes in the report"

# Moments of degree 2 and 3 are there; a run to degree 1 over the same file takes them away again; so does --keep-moments 1.
moments() { p1solve "$1" --dry-run --json - -q -o x.vdb | grep -c '"name": "sh_' || true; }
[ "$(moments one.vdb)" = 12 ] || fail "degree 3: $(moments one.vdb) moments of degree 2 and more, expected 12"
p1solve one.vdb --g 0.85 --iterations 1 --reentry-rays 0 -q -o again.vdb
# Channels with light of one colour share their moments, times what each is; other albedos have their own. The picture is the same.
$solve --iterations 2 --degree 3 --sun 0.3,1,0.2 --sun-irradiance 3,2,1 -o tinted.vdb
[ "$(moments tinted.vdb)" = 12 ] || fail "light of one tint: $(moments tinted.vdb) moments, expected 12"
p1solve light.vdb --g 0.85 --reentry-rays 0 -q --iterations 2 --degree 3 --sun 0.3,1,0.2 --sun-irradiance 3,2,1 \
    --albedo 0.999,0.999,0.998 -o apart.vdb
[ "$(moments apart.vdb)" = 36 ] || fail "two albedos: $(moments apart.vdb) moments, expected 36"
p1solve light.vdb --g 0.85 --reentry-rays 0 -q --iterations 2 --degree 3 --sun 0.3,1,0.2 --sun-irradiance 3,2,1 \
    --albedo 0.999,0.999,0.999000001 -o same.vdb
for f in tinted same; do render $f.vdb --resolution 24 --aov multiscatter -q -o $f.exr; done
oiiotool tinted.exr same.exr --diff --fail 1e-3 --warn 1e-3 > /dev/null || fail "shared moments and moments apart give two pictures"
[ "$(moments again.vdb)" = 0 ] || fail "moments of an earlier run were kept"
$solve --iterations 1 --degree 3 --keep-moments 1 -o few.vdb
[ "$(moments few.vdb)" = 0 ] || fail "--keep-moments 1 keeps moments"

# render takes all moments, and says when they were not kept.
render one.vdb --resolution 24 -q -o one.exr
render few.vdb --resolution 24 -o few.exr 2> said
grep -q "kept to degree 1" said || fail "render does not say that moments are missing"

refused 2 p1solve light.vdb --degree 3 -q -o x.vdb
refused 2 p1solve light.vdb --iterations 2 --series 3 -q -o x.vdb
refused 2 p1solve light.vdb --iterations 2 --solver relaxation -q -o x.vdb
refused 2 p1solve light.vdb --iterations 2 --degree 8 -q -o x.vdb
refused 1 p1solve light.vdb --iterations 2 --degree 7 --quadrature level-symmetric -q -o x.vdb
