#!/usr/bin/env bash
# README's pipes by two builds, in turn: processor seconds of each program, and the ratio of medians. Two builds that are
# measured at different hours of a shared machine tell nothing.
# Usage: pipes.sh BEFORE_BIN AFTER_BIN [ROUNDS] [SIZE], default 3 rounds at 128^3, prints a table. In each round the builds run
# in the order before, after, after, before. What the older build refuses stands as "-" and in neither sum.
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: pipes.sh BEFORE_BIN AFTER_BIN [ROUNDS] [SIZE]" >&2; exit 2; }
before=$(cd "$1" && pwd) after=$(cd "$2" && pwd) rounds=${3:-3} size=${4:-128}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# cpu BUILD STAGE COMMAND...: runs a program and notes its user and system seconds.
cpu() {
    local build=$1 stage=$2 TIMEFORMAT='%U %S'
    shift 2
    { time "$@" > said 2>&1 3>&-; } 2> seconds || {
        [ "$build" = before ] && return
        echo "pipes.sh: $*: $(tail -n 1 said)" >&2
        exit 1
    }
    awk -v b="$build" -v s="$stage" '{ print b, s, $1 + $2 }' seconds >> all
}

# The cloud, lit and seen; with multiple scattering; two clouds solved as one medium.
pipes() {
    local build=$1 bin=${!1}
    cpu "$build" fractalgen "$bin/fractalgen" --seed 7 --size "$size" -q -o cloud.vdb
    cpu "$build" illuminate "$bin/illuminate" cloud.vdb --sun 0.3,1,0.2 -q -o light.vdb
    cpu "$build" render-once "$bin/render" light.vdb -q -o cloud.exr --png cloud.png
    cpu "$build" p1solve-sweeps "$bin/p1solve" light.vdb --albedo 0.9999 --g 0.85 --iterations 3 -q -o lit.vdb
    cpu "$build" render-many "$bin/render" lit.vdb -q -o smoke.exr --png smoke.png
    cpu "$build" fractalgen "$bin/fractalgen" --seed 3 --envelope sphere --size $((size / 2)) -q -o high.vdb
    cpu "$build" p1solve-two "$bin/p1solve" high.vdb cloud.vdb --sun 0.3,1,0.2 --albedo 0.9999 --g 0.85 --iterations 3 --extinction 20 -q \
        -o both.vdb
    cpu "$build" render-two "$bin/render" both.vdb -q -o both.exr --png both.png
}
for ((k = 0; k < rounds; ++k)); do
    for build in before after after before; do pipes $build; done
done

# median BUILD STAGE
median() { awk -v b="$1" -v s="$2" '$1 == b && $2 == s { print $3 }' all | sort -g | awk '{ v[NR] = $1 } END { print NR ? (v[int((NR + 1) / 2)] + v[int(NR / 2) + 1]) / 2 : "-" }'; }
printf '| program | before [s] | after [s] | after / before |\n|---|--:|--:|--:|\n'
awk '!seen[$2]++ { print $2 }' all | while read -r stage; do
    printf '%s %s %s\n' "$stage" "$(median before "$stage")" "$(median after "$stage")"
done | awk '
    $2 == "-" { printf "| %s | - | %.2f | - |\n", $1, $3; next }
    { b += $2; a += $3; printf "| %s | %.2f | %.2f | %.2f |\n", $1, $2, $3, $3 / $2 }
    END { printf "| all | %.2f | %.2f | %.2f |\n", b, a, a / b }'
