#!/usr/bin/env bash
# Transport sweeps through the programs: which moments p1solve writes, what it reports and refuses, and equal files for any
# number of threads.
# Usage: sweeps.sh BIN
set -euo pipefail
PATH=$1:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "sweeps.sh: $*" >&2; exit 1; }
# refused STATUS COMMAND...: the command ends with that status and prints one line on standard error.
refused() {
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
vdbdiff one.vdb two.vdb || fail "files of one thread and of two threads differ"
grep -q '"directions": 64' report.json || fail "40 directions for degree 3 are not reported as 64"
changes=$(grep -A12 '"change": \[' report.json | grep -cE '^ *[0-9.e-]+,?$') || true
[ "$changes" -ge 3 ] || fail "the report has $changes changes, expected 3 or more"

# A run of degree 3 writes moments of degree 2 and 3. A run of degree 1 on that file removes them; so does --keep-moments 1.
moments() { p1solve "$1" --dry-run --json - -q -o x.vdb | grep -c '"name": "sh_' || true; }
[ "$(moments one.vdb)" = 12 ] || fail "degree 3: $(moments one.vdb) moments of degree 2 and more, expected 12"
p1solve one.vdb --g 0.85 --iterations 1 --reentry-rays 0 -q -o again.vdb
# Channels of one albedo share moments, scaled by the colour of the light. Channels of different albedos have their own.
# Both give the same picture.
$solve --iterations 2 --degree 3 --sun 0.3,1,0.2 --sun-irradiance 3,2,1 -o tinted.vdb
[ "$(moments tinted.vdb)" = 12 ] || fail "light of one tint: $(moments tinted.vdb) moments, expected 12"
p1solve light.vdb --g 0.85 --reentry-rays 0 -q --iterations 2 --degree 3 --sun 0.3,1,0.2 --sun-irradiance 3,2,1 \
    --albedo 0.999,0.999,0.998 -o apart.vdb
[ "$(moments apart.vdb)" = 36 ] || fail "two albedos: $(moments apart.vdb) moments, expected 36"
p1solve light.vdb --g 0.85 --reentry-rays 0 -q --iterations 2 --degree 3 --sun 0.3,1,0.2 --sun-irradiance 3,2,1 \
    --albedo 0.999,0.999,0.999000001 -o same.vdb
for f in tinted same; do render $f.vdb --resolution 24 --aov multiscatter -q -o $f.exr; done
oiiotool tinted.exr same.exr --diff --fail 1e-3 --warn 1e-3 > /dev/null || fail "shared and separate moments give different pictures"
[ "$(moments again.vdb)" = 0 ] || fail "a run of degree 1 keeps moments of degree 2 and more"
$solve --iterations 1 --degree 3 --keep-moments 1 -o few.vdb
[ "$(moments few.vdb)" = 0 ] || fail "--keep-moments 1 keeps moments"

# render uses all moments, and says which degrees the file lacks.
render one.vdb --resolution 24 -q -o one.exr
render few.vdb --resolution 24 -o few.exr 2> said
grep -q "kept to degree 1" said || fail "render does not say that the file has moments to degree 1 only: $(cat said)"

refused 2 p1solve light.vdb --degree 3 -q -o x.vdb
refused 2 p1solve light.vdb --iterations 2 --series 3 -q -o x.vdb
refused 2 p1solve light.vdb --iterations 2 --solver relaxation -q -o x.vdb
refused 2 p1solve light.vdb --iterations 2 --degree 8 -q -o x.vdb
refused 1 p1solve light.vdb --iterations 2 --degree 7 --quadrature level-symmetric -q -o x.vdb
