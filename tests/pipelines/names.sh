#!/usr/bin/env bash
# Pipelines and the names of things: a file of any name is data, paths are meant from where the user stands, and what a
# variable names is never a picture of what it named before.
# Usage: [SIZE=full] names.sh BIN; SIZE=full gives each odd character a name of its own, too
set -euo pipefail
bin=$(cd "$1" && pwd)
top=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trap 'echo "names.sh: line $LINENO failed" >&2' ERR
fail() { echo "names.sh: $*" >&2; exit 1; }
# make is called by a user, whose environment has names of its own.
unset MAKELEVEL MAKEFLAGS MFLAGS
export VDBCLOUD_START=/nowhere
# A copy of the pipelines, in a folder that is no word of a Makefile either. The programs have one of their own.
copy="$folder/it's a \$(touch ran) copy"
mkdir -p "$copy/build"
cp -r "$top/pipelines" "$top/cmake" "$copy"
find "$copy/pipelines" -type d -name out -prune -exec rm -rf {} +
ln -s "$bin" "$copy/build/bin"
picture() { make -s --no-print-directory -C "$copy/pipelines/any" PICTURE=small render_flags="${size:---resolution 16}" "$@" < /dev/null; }
path_of() { picture "$@" 2>&1 | sed -n '1p'; }

# Two files of one name, the second of them older: shapes that differ.
mkdir "$folder/A" "$folder/B"
"$bin/fractalgen" -q --size 12 --envelope sphere -o "$folder/A/smoke.vdb"
"$bin/fractalgen" -q --size 12 --seed 5 -o "$folder/B/smoke.vdb"
touch -d '2001-01-01' "$folder/B/smoke.vdb"
cd "$folder"
a=$(path_of DENSITY=A/smoke.vdb)
[ -s "$a" ] || fail "DENSITY=A/smoke.vdb, relative: no picture ('$a')"
cp "$a" a.png
b=$(path_of DENSITY=B/smoke.vdb)
[ "$a" = "$b" ] || fail "two files smoke.vdb: expected one picture, got '$a' and '$b'"
cmp -s a.png "$b" && fail "the picture of B/smoke.vdb, which is older, is that of A/smoke.vdb"
cp "$b" b.png
[ -z "$(path_of DENSITY=B/smoke.vdb)" ] || fail "the same again makes something"
path_of DENSITY="$folder/A/../A/smoke.vdb" > /dev/null
cmp -s a.png "$a" || fail "A/smoke.vdb after B/smoke.vdb is not the picture of A"

# A file in the place of another, under its name: newer, and older.
cp A/smoke.vdb here.vdb
here=$(path_of DENSITY=here.vdb)
for other in B/smoke.vdb A/smoke.vdb; do
    cp -p $other here.vdb
    path_of DENSITY=here.vdb > /dev/null
    cmp -s "$([ $other = A/smoke.vdb ] && echo a.png || echo b.png)" "$here" || fail "$other in the place of the other file: not its picture"
done
[ -z "$(path_of DENSITY=here.vdb)" ] || fail "the same file again makes something"
picture DENSITY=$'A/smo\nke.vdb' > said 2>&1 && fail "a path with a line break: expected a refusal"
grep -q "DENSITY holds a line break: expected" said || fail "a path with a line break: $(cat said)"

# What programs are told, and which programs.
light="${a%.png}.light.vdb"
before=$(stat -c %y "$light")
size='--resolution 20' path_of DENSITY=A/smoke.vdb > /dev/null
[ "$(stat -c %y "$light")" = "$before" ] || fail "another resolution made the light again"
cmp -s a.png "$a" && fail "another resolution did not make the picture again"
cp "$a" a20.png
mkdir "$folder/other programs"
cp "$bin"/{illuminate,render} "$folder/other programs"
size='--resolution 20' picture DENSITY=A/smoke.vdb BIN="$folder/other programs" light_flags='--extinction 3' > /dev/null
[ "$(stat -c %y "$light")" != "$before" ] || fail "other programs did not make the light again"
cmp -s a20.png "$a" && fail "a thinner medium has the same picture"
# Folders of the user are meant from where the user stands.
picture DENSITY=A/smoke.vdb BIN="other programs" OUT=my/pictures > /dev/null
cmp -s a.png my/pictures/smoke.png || fail "BIN and OUT, relative: not the picture, or not there"
(cd A && picture DENSITY=smoke.vdb BIN="../other programs" OUT=../mine > /dev/null)
cmp -s a.png mine/smoke.png || fail "BIN and OUT from another folder: not the picture, or not there"
picture DENSITY=A/smoke.vdb BIN=none OUT=mine/too > said 2>&1 && fail "BIN=none: expected a refusal"
grep -q "none/.* is not built" said || fail "BIN=none: $(cat said)"

# No name runs anything, or is taken for something else. A name of several odd characters shows a fault of each of them.
names=('-f a b' "it's x:y%p" 'x`touch ran`d$(touch ran)' 's$(shell touch ran)e"q' '#h b\s$HOME a*' ';touch ran$$' "a'b'\$(touch ran)")
[ "${SIZE:-}" != full ] || names+=('a b' "it's" 'x:y' 'x`touch ran`' 'd$(touch ran)' 's$(shell touch ran)' 'e"q' '#h' '%p' '-f' 'b\s' '$HOME' 'a*' ';touch ran' '$$' "a'b'\$(touch ran)")
for name in "${names[@]}"; do
    cp A/smoke.vdb "./$name.vdb"
    made=$(path_of DENSITY="$name.vdb")
    [ -s "$made" ] || fail "DENSITY='$name.vdb': no picture: $(picture DENSITY="$name.vdb" 2>&1 | head -n 1)"
    cmp -s a.png "$made" || fail "DENSITY='$name.vdb': another picture"
done
ran=$(find "$folder" "$top/pipelines" -name ran)
[ -z "$ran" ] || fail "a name ran a command: $ran"

# RUNG: a change makes again what depends on it, and no more; a word that is no rung is refused, and runs nothing.
cp -r "$top/data" "$copy"
at_rung() { picture DENSITY=A/smoke.vdb OUT=rung "$@"; }
stages() { for f in light.vdb scatter.vdb exr; do [ -e rung/smoke.$f ] && stat -c '%n %y' rung/smoke.$f; done; true; }
at_rung RUNG=0 > /dev/null
[ ! -e rung/smoke.scatter.vdb ] || fail "RUNG=0 solves"
zero=$(stages)
at_rung RUNG=0 > /dev/null
[ "$(stages)" = "$zero" ] || fail "RUNG=0 again makes something"
at_rung RUNG=1 > /dev/null
[ -e rung/smoke.scatter.vdb ] || fail "RUNG=1 does not solve"
one=$(stages)
at_rung RUNG=2 > /dev/null
[ -z "$(comm -12 <(sort <<< "$one") <(stages | sort))" ] || fail "RUNG=2 after RUNG=1 keeps a file: $(stages)"
vdb_print -m rung/smoke.scatter.vdb | grep 'p1solve .*iterations=3 ' > /dev/null || fail "RUNG=2: expected three sweeps"
for wrong in 7 x '1 2' '$(shell touch ran)' "'; touch ran; '" '`touch ran`' -1 03; do
    at_rung RUNG="$wrong" > said 2>&1 && fail "RUNG='$wrong': expected a refusal"
    grep -qF "expected one of 0 1 2 3 4 5 6" said || fail "RUNG='$wrong': $(cat said)"
done
ran=$(find "$folder" "$top/pipelines" -name ran)
[ -z "$ran" ] || fail "a rung ran a command: $ran"

# A frame of the film with detail, then without: made of the simulation's file, which is older than both.
frame() { make -s --no-print-directory -C "$copy/pipelines/cumulus-growth" OUT="$folder/film" DETAIL="$1" "$folder/film/growth.0000.light.vdb" > said 2>&1 || fail "DETAIL=$1: $(cat said)"; }
mkdir film
"$bin/fractalgen" -q --size 12 -o film/growth.0000.coarse.vdb
make -n -s -C "$copy/pipelines/cumulus-growth" OUT="$folder/film" > /dev/null 2>&1 || true
touch film/growth.simulated
frame 2
cp film/growth.0000.light.vdb detailed.vdb
frame 1
! cmp -s film/growth.0000.light.vdb detailed.vdb || fail "DETAIL=1 after DETAIL=2 is lit as before"
"$bin/vdbdiff" --quiet film/growth.0000.{coarse,density}.vdb || fail "DETAIL=1: not the simulation's density"

# The real cloud's folder is relative, too; what is not there is said.
mkdir 'real clouds'
cp B/smoke.vdb 'real clouds/wdas_cloud_sixteenth.vdb'
make -s --no-print-directory -C "$copy/pipelines/disney" PICTURE=small render_flags='--resolution 16' VDBCLOUD_REAL='real clouds' > said
[ -s "$(sed -n 1p said)" ] || fail "VDBCLOUD_REAL='real clouds': $(cat said)"
picture DENSITY=none.vdb > said 2>&1 && fail "a missing file is not an error"
grep -q "none.vdb'.*no such file" said || fail "a missing file: $(cat said)"
picture DENSITY=A/smoke.vdb OUT='o u t' > said 2>&1 && fail "OUT with spaces: expected a refusal"
grep -q "OUT = 'o u t': expected" said || fail "OUT with spaces: $(cat said)"

# The folder of I3RC's clouds, in a place that would run a command.
mkdir 'i3rc `touch ran`'
plan=$(make -n -k -C "$copy/pipelines/benchmarks/i3rc" OUT=plan VDBCLOUD_I3RC='i3rc `touch ran`' 2>&1 || true)
grep -qF "'$folder/i3rc \`touch ran\`/mmcr_tau_32km_020898'" <<< "$plan" || fail "VDBCLOUD_I3RC, relative: not read, or not quoted"
ran=$(find "$folder" -name ran)
[ -z "$ran" ] || fail "the folder of I3RC ran a command: $ran"

# Reading a pipeline again changes nothing that its files depend on.
for pipeline in "$copy"/pipelines/*/; do
    for time in first second; do
        (cd "$pipeline" && make PICTURE=small OUT=out/told -n -k all) > said 2>&1 || true
        ! grep -E "make.*(warning|invalid)|cloud.mk.*warning|^Usage: make" said || fail "$pipeline: make takes its folder's name for several"
        [ $time = second ] || { sleep 0.01; touch "$folder/between"; sleep 0.01; }
    done
    again=$(find "$pipeline" \( -name '*.told' -o -name '*.part' \) -newer "$folder/between")
    [ -z "$again" ] || fail "read twice, pipelines write anew: $again"
    [ -e "$pipeline/out/told/render.told" ] || fail "$pipeline: expected out/told/render.told"
done

# A picture that has the folder's name, and the gallery's of it.
for pipeline in fractal-cumulus gallery; do
    make -s --no-print-directory -C "$copy/pipelines/$pipeline" PICTURE=small PICTURES=fractal-cumulus CERTIFY=1 density_flags='--size 16' \
        render_flags='--resolution 32x18' > said 2>&1 || fail "$pipeline: $(cat said)"
done
[ -s "$copy/pipelines/fractal-cumulus/out/small/fractal-cumulus.png" ] || fail "fractal-cumulus: no picture of its name"
grep -q '<figure id="fractal-cumulus">' "$copy/pipelines/gallery/out/small/index.html" || fail "the gallery has no picture"

# why names what a change would make; clean removes the files of any pipeline.
[ "$(make -s --no-print-directory -C "$copy/pipelines/any" PICTURE=small render_flags='--resolution 16' DENSITY=B/smoke.vdb why | grep -c render)" -ge 1 ] ||
    fail "why does not know the pipeline of a user's density"
make -s --no-print-directory -C "$copy/pipelines" clean > /dev/null
left=$(find "$copy/pipelines" -name "*.vdb" -o -name "*.told" -o -name "*.part")
[ -z "$left" ] || fail "clean left $left"
