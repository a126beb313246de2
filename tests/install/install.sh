#!/usr/bin/env bash
# An installation that was moved builds a program by CMake package and by pkg-config, and starts every program by the
# one command, also through a symbolic link. Usage: install.sh BUILD
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "install.sh: $*" >&2; exit 1; }
programs="fractalgen cloudsim vdbimport vdbexport illuminate p1solve render exrmerge vdbdiff vdbprobe"

cmake --install "$build" --prefix "$folder/first" > install.log 2>&1 || { cat install.log; fail "cmake --install failed"; }
mv first moved
prefix=$folder/moved

# Names as short as `render` stay out of the path.
[ "$(ls "$prefix/bin")" = vdbcloud ] || fail "bin holds $(ls "$prefix/bin"), expected vdbcloud alone"
installed=$(cd "$prefix/libexec/vdbcloud" && printf '%s\n' * | sort | xargs)
[ "$installed" = "$(tr ' ' '\n' <<< "$programs" | sort | xargs)" ] || fail "libexec/vdbcloud holds $installed, expected $programs"

# The command, through a symbolic link.
mkdir path
ln -s "$prefix/bin/vdbcloud" path/vdbcloud
PATH=$folder/path:$PATH
help=$(vdbcloud --help)
for program in $programs; do
    grep -qE "^  $program +[A-Z].*\.$" <<< "$help" || fail "vdbcloud --help does not describe $program: $help"
    [ "$(vdbcloud "$program" --version | head -n 1)" = "$program (vdbcloud) $(vdbcloud --version | cut -d ' ' -f 2)" ] ||
        fail "vdbcloud $program --version: another version than vdbcloud --version"
done
status=0; message=$(vdbcloud rendr 2>&1) || status=$?
[ "$status $message" = "2 vdbcloud: unknown program 'rendr'; did you mean 'render'?" ] ||
    fail "vdbcloud rendr: status $status, $message"
status=0; message=$(vdbcloud 2>&1) || status=$?
[ $status = 2 ] || fail "vdbcloud without a program: status $status, expected 2"
status=0; vdbcloud vdbdiff missing.vdb missing.vdb 2> /dev/null || status=$?
[ $status = 1 ] || fail "the status of a program does not pass through: $status, expected 1"

# OpenImageIO's shared libraries are loaded where a picture needs them, and from the moved folder.
module=$(find "$prefix/lib" -name vdbcloud_openimageio.so)
for program in "$prefix"/libexec/vdbcloud/*; do
    ! ldd "$program" | grep -q libOpenImageIO || fail "$program loads OpenImageIO at its start"
done
vdbcloud fractalgen --size 8 -q -o small.vdb
vdbcloud render small.vdb --resolution 8 -q -o small.png
[ "$(head -c 4 small.png | tail -c 3)" = PNG ] || fail "render writes no .png"
mv "$module" "$module.away"
status=0; message=$(vdbcloud render small.vdb --resolution 8 -q -o other.png 2>&1) || status=$?
mv "$module.away" "$module"
[[ "$status $message" = "1 render: other.png: cannot load OpenImageIO: "*vdbcloud_openimageio.so* ]] && [ ! -e other.png ] ||
    fail "render without its module: status $status, $message"
vdbcloud render small.vdb --resolution 8 -q -o small.exr || fail "render writes no .exr"

# A box under a vertical sun: 30 voxels of density 1 in each column between two faces of the density `edge`, voxels of
# 1/16, sigma_t 0.5. The smallest transmittance is exp(-tau) with tau = 0.5 (30 + 2 edge) / 16: trilinear density sums
# exactly over a column. Float values and their printing with six digits allow 1e-5.
vdbcloud fractalgen --envelope box --warp 0 --roughness 0 --edge 0 --size 32 --bounds=-1,-1,-1,1,1,1 \
    --json box.json -q -o box.vdb
edge=$(sed -n 's/^ *"min": \([0-9.]*\),$/\1/p' box.json)
check() {
    awk -v t="$1" -v e="$edge" 'BEGIN { d = t - exp(-0.5 * (30 + 2 * e) / 16); exit !(e > 0 && d < 1e-5 && d > -1e-5) }' ||
        fail "$2 prints the transmittance $1 for faces of density $edge, expected exp(-0.5 (30 + 2 x $edge) / 16)"
}

# A library with a sanitizer asks for programs with it.
sanitizers=$(sed -n 's/^CMAKE_CXX_FLAGS:STRING=//p' "$build/CMakeCache.txt" | grep -o -- '-fsanitize=[a-z,-]*' || true)
{ cmake -S "$here/example" -B by-cmake -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS="$sanitizers" && cmake --build by-cmake; } > cmake.log 2>&1 ||
    { cat cmake.log; fail "find_package(vdbcloud) does not build the example"; }
printed=$(by-cmake/transmittance box.vdb)
check "$printed" "the example built by CMake"

export PKG_CONFIG_PATH
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name vdbcloud.pc)")
# shellcheck disable=SC2046  # flags are words
g++ $sanitizers "$here/example/transmittance.cc" -o by-pkg-config $(pkg-config --cflags --libs vdbcloud) 2> pkg-config.log ||
    { cat pkg-config.log; fail "pkg-config vdbcloud does not build the example"; }
printed=$(./by-pkg-config box.vdb)
check "$printed" "the example built by pkg-config"
echo "transmittance below the box: $printed"

# Every installed header compiles alone, without the tree.
find "$prefix/include" -name '*.h' | sed "s,^$prefix/include/,,; s/.*/#include <&>/" > all.cc
# shellcheck disable=SC2046
g++ -fsyntax-only $(pkg-config --cflags vdbcloud) all.cc || fail "the installed headers include what is not installed"

# Manual pages and completions.
if command -v help2man > /dev/null; then
    for program in $programs; do
        page=$(find "$prefix/share/man" -name "vdbcloud-$program.1")
        grep -q "^vdbcloud-$program .- [A-Z]" "$page" || fail "$page: no NAME vdbcloud-$program"
        grep -qxF ".B vdbcloud $program" "$page" || fail "$page: no SYNOPSIS vdbcloud $program"
        grep -qF -e 'dry\-run' "$page" || fail "$page: no option --dry-run"
    done
fi
completed=$(bash -c ". '$prefix/share/bash-completion/completions/vdbcloud'
    COMP_WORDS=(vdbcloud render --expos) COMP_CWORD=2; _vdbcloud; echo \"\${COMPREPLY[*]}\"")
[ "$completed" = "--exposure" ] || fail "bash completes 'vdbcloud render --expos' to '$completed', expected --exposure"
for file in zsh/site-functions/_vdbcloud fish/vendor_completions.d/vdbcloud.fish; do
    grep -q -e 'exposure' "$prefix/share/$file" || fail "$file does not know render's options"
done
[ -s "$prefix/share/doc/vdbcloud/LICENSE" ] || fail "the licence is not installed"
