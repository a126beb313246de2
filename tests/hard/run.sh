#!/usr/bin/env bash
# All hard cases and random worlds as one table, which is written to docs/hard-cases.md. `make -C tests hard` calls it.
# Usage: run.sh BUILD
#
#   SIZE=full          worlds 1 to 10000 instead of 1 to 300, 5000 hostile files for each program instead of 300, 200
#                      frames of a soak instead of 10
#   SEEDS=first-last   these worlds and hostile files alone, added to those of earlier runs
#
# Rows are kept in BUILD/hard by ranges of 100 seeds, under a hash of the programs and of the suite: an interrupted run
# continues, and rows of other programs do not count. Exit status: 0 all hold, 1 some fail, 2 usage.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
[ $# = 1 ] || { echo "usage: run.sh BUILD (see the comment at its top)" >&2; exit 2; }
bin=$(cd "$1/bin" && pwd)
seeds=${SEEDS:-1-$([ "${SIZE:-}" = full ] && echo 10000 || echo 300)}
[[ $seeds =~ ^([0-9]+)-([0-9]+)$ ]] || { echo "run.sh: SEEDS=$seeds: expected first-last" >&2; exit 2; }
first=${BASH_REMATCH[1]} last=${BASH_REMATCH[2]}
key=$(cat "$bin"/{fractalgen,cloudsim,vdbimport,vdbexport,illuminate,p1solve,render,exrmerge,vdbdiff,vdbprobe,hard} "$here/cases.txt" "$here/faults.sh" | sha1sum | cut -c 1-12)
work=$1/hard/$key
mkdir -p "$work"
failed=0

# part NAME COMMAND...: rows of one part, unless they are there.
part() {
    local name=$1; shift
    [ ! -e "$work/$name.csv" ] || return 0
    "$@" > "$work/$name.new" 2> "$work/$name.log" || { failed=1; cat "$work/$name.log" >&2; }
    mv "$work/$name.new" "$work/$name.csv"
}

hostile=5000
part "soak-${SIZE:-small}" "$bin/hard" soak $([ "${SIZE:-}" = full ] && echo 200 || echo 10)
part cases "$bin/hard" cases "$here/cases.txt"
part "faults-${SIZE:-small}" "$here/faults.sh" "$bin"
for ((a = first; a <= last; a += 100)); do
    b=$((a + 99 < last ? a + 99 : last))
    part "worlds-$(printf %06d "$a")-$(printf %06d "$b")" "$bin/hard" worlds "$a" "$b"
done
for ((a = first; a <= last && a <= hostile; a += 100)); do
    b=$((a + 99 < last ? a + 99 : last))
    part "hostile-$(printf %06d "$a")-$(printf %06d "$b")" "$bin/hard" hostile all "$a" "$b"
done
seconds=$(sed -n 's/.* programs, \(.*\) processor seconds/\1/p' "$work"/*.log | awk '{s += $1} END {printf "%.0f", s}')
runs=$(sed -n 's/\(.*\) runs of programs.*/\1/p' "$work"/*.log | awk '{s += $1} END {print s}')
parts=$(cd "$work" && ls worlds-*.csv | sed 's/worlds-0*\([0-9]*\)-0*\([0-9]*\).csv/\1-\2/' | awk -F- '
    NR == 1 {a = $1} NR > 1 && $1 != b + 1 {printf "%s%d-%d", c++ ? ", " : "", a, b; a = $1} {b = $2} END {printf "%s%d-%d", c ? ", " : "", a, b}')
hostile_tables=("$work"/hostile-*.csv)
[ -e "${hostile_tables[0]}" ] || hostile_tables=()
{
    cat "$here/page.md"
    echo "Seeds $parts; $runs runs of programs in $seconds processor seconds."
    echo
    "$bin/hard" table "$work"/cases.csv "$work/faults-${SIZE:-small}.csv" "$work/soak-${SIZE:-small}.csv" "${hostile_tables[@]}" "$work"/worlds-*.csv
} > "$work/page" || failed=1
cp "$work/page" "$here/../../docs/hard-cases.md"
sed -n '/^| case/,$p' "$work/page"
echo "seeds $parts, $runs runs of programs, $seconds processor seconds"
exit $failed
