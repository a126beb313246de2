#!/usr/bin/env bash
# Puts one fault at a time into a copy of the tree and asks one test whether it notices. `make -C tests mutants` calls it.
#
#   run.sh BUILD          every record of tests/mutants/*.txt
#   ONLY=pattern          only records whose "module/name" matches this extended regular expression
#   JOBS=n                processor cores to use (default: all)
#   LIMIT=seconds         time limit of one test run (default 120); a test that exceeds the limit counts as red
#   CHECK=1               only checks that each record is complete and applies to its file; builds and runs nothing
#
# A record is a block of lines; blank lines separate records, # begins a comment line:
#
#   name: prolongation-half         unique within its file
#   file: libvdbcloud/vdbcloud/solve/multigrid.cc
#   from: 2 * residual              a piece of one line; it occurs exactly once in the file
#   to:   residual                  replaces `from`; may be empty
#   test: test_solve --gtest_filter=Multigrid*
#   equivalent: why                 optional: no test can notice this fault, for this reason
#
# Results are kept in BUILD/mutants/results.tsv under a hash of the record, the patched file and the sources of the test,
# so an interrupted run continues and a second run repeats only what changed. Delete the file to repeat everything.
# With ccache there are JOBS copies and each runs faults of its own; without ccache there is one.
# Exit status: 0 all killed, 1 some survive or a record is wrong, 2 usage.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
top=$(cd "$here/../.." && pwd)
[ $# = 1 ] || { echo "usage: run.sh BUILD (see the comment at its top)" >&2; exit 2; }
mkdir -p "$1/mutants"
work=$(cd "$1/mutants" && pwd)
results=$work/results.tsv
jobs=${JOBS:-$(nproc)}
limit=${LIMIT:-120}
separator=$'\x1f'

if [ -n "${CHECK:-}" ]; then
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
else
    exec 9> "$work/lock"
    flock -n 9 || { echo "mutants: another run uses $work" >&2; exit 2; }
    trap 'kill $(jobs -p) 2>/dev/null || true' EXIT
    touch "$results"
fi

# Prints "module name file from to test equivalent", one record a line, separated by the unit separator.
read_records() {
    awk -v S="$separator" '
        function fail(text) { printf "%s:%d: %s\n", FILENAME, FNR, text > "/dev/stderr"; failed = 1; exit 2 }
        function finish(   key) {
            if (!open) return
            for (key in needed) if (!(key in value)) fail("record " value["name"] " lacks " key ":")
            if (seen[module "/" value["name"]]++) fail("two records are named " value["name"])
            print module S value["name"] S value["file"] S value["from"] S value["to"] S value["test"] S value["equivalent"]
            split("", value); open = 0
        }
        BEGIN { split("name file from to test", words, " "); for (i in words) needed[words[i]]; optional["equivalent"] }
        FNR == 1 { finish(); module = FILENAME; sub(/.*\//, "", module); sub(/\.txt$/, "", module) }
        /^#/ { next }
        /^[ \t]*$/ { finish(); next }
        {
            key = $0; sub(/:.*/, "", key)
            if (!(key in needed) && !(key in optional)) fail("expected name:, file:, from:, to:, test: or equivalent:, got \"" $0 "\"")
            if (key in value) fail(key ": is given twice in one record")
            text = $0; sub(/^[a-z]*:[ \t]*/, "", text)
            value[key] = text; open = 1
        }
        END { if (!failed) finish() }' "$@"
}

# occurrences FILE: how many times $from occurs in FILE.
occurrences() {
    from=$from awk 'BEGIN { from = ENVIRON["from"] }
        { text = $0; while ((at = index(text, from)) > 0) { n++; text = substr(text, at + length(from)) } }
        END { print n + 0 }' "$1"
}

# patched FILE: FILE with $from replaced by $to.
patched() {
    from=$from to=$to awk 'BEGIN { from = ENVIRON["from"]; to = ENVIRON["to"] }
        (at = index($0, from)) > 0 { $0 = substr($0, 1, at - 1) to substr($0, at + length(from)) } { print }' "$1"
}

# files_of FOLDER: the files that a copy needs, sorted.
files_of() {
    (cd "$1" && find . \( -path ./.git -o -path './build*' -o -name out \) -prune -o -type f -print | LC_ALL=C sort)
}

# Brings a copy up to date. Only files that differ are written, so that ninja rebuilds only what depends on them.
synchronise() {
    local tree=$1 file
    mkdir -p "$tree"
    LC_ALL=C comm -13 <(files_of "$top") <(files_of "$tree") | while read -r file; do rm "$tree/$file"; done
    files_of "$top" | while read -r file; do
        cmp -s "$top/$file" "$tree/$file" || { mkdir -p "$(dirname "$tree/$file")"; cp "$top/$file" "$tree/$file"; }
    done
    [ -e "$tree/build/build.ninja" ] || cmake -G Ninja -S "$tree" -B "$tree/build" -DCMAKE_BUILD_TYPE=Release \
        "${launcher[@]}" > "$tree/../configure.log" 2>&1 || { cat "$tree/../configure.log" >&2; exit 1; }
}

# The build folder lies in the copy as `build` lies in the tree: with ccache a copy shares the objects of the tree.
launcher=()
copies=1
if command -v ccache > /dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    copies=$jobs
    export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$top} CCACHE_NOHASHDIR=1
fi
ninja_jobs=$((jobs / copies))

# test_sources PROGRAM: the sources of a test program below tests/ and the headers beside them.
test_sources() {
    local sources
    sources=$(ninja -C "$work/1/tree/build" -t inputs "$1" | grep -o "/tree/tests/.*\.cc$" | sed 's,^/tree/,,' | sort -u)
    printf '%s\n' "$sources"
    printf '%s\n' "$sources" | xargs -r -n 1 dirname | sort -u | while read -r folder; do
        find "$top/$folder" -maxdepth 1 -name '*.h' -printf "$folder/%f\n"
    done | sort
}

# run_test COPY LOG: runs $test in a copy. The memory limit stops a fault that allocates without end. set -f: a filter such
# as *Name* is a word for the program, not a pattern of file names, which nullglob would drop.
run_test() {
    local run=$1/run
    rm -rf "$run"; mkdir -p "$run/tmp"
    # shellcheck disable=SC2086  # a program and its options
    (set -f; ulimit -v $((8 << 20)); cd "$run" && TMPDIR=$run/tmp timeout -k 5 "$limit" "$1/tree/build/bin/"$test > "$2" 2>&1 < /dev/null)
}

# report STATUS SECONDS: a verdict on the current record.
report() {
    printf '%-32s %4s s  %s\n' "$1" "$2" "$module/$name"
    printf '%s\t%s\t%s\t%s\n' "$key" "$1" "$2" "$module/$name" >> "$results"
}

# undecided WHY: the current record gets no verdict in this run, and the next run tries it again.
undecided() {
    printf '%-32s         %s\n' "$1" "$module/$name"
    tail -n 20 "$log" | sed 's/^/    /'
}

# worker N FILE: applies the records of FILE in copy N. The next record restores the file of the last one, so that several
# faults in one file cost one compilation each.
worker() {
    local copy=$work/$1 changed="" begin program status log
    synchronise "$copy/tree"
    while IFS=$separator read -r key module name file from to test equivalent; do
        begin=$SECONDS; program=${test%% *}; log=$copy/log
        [ -z "$changed" ] || [ "$changed" = "$file" ] || cp "$top/$changed" "$copy/tree/$changed"
        if ! grep -qxF "$test" "$copy/green" 2> /dev/null; then
            [ "$changed" != "$file" ] || cp "$top/$file" "$copy/tree/$file"
            changed=""
            if ! ninja -C "$copy/tree/build" -j "$ninja_jobs" "$program" > "$log" 2>&1; then
                undecided "$program does not build"; continue
            fi
            if ! run_test "$copy" "$log"; then
                undecided "test fails without the fault"; continue
            fi
            if grep -q 'Running 0 tests' "$log"; then
                undecided "filter selects no test"; continue
            fi
            printf '%s\n' "$test" >> "$copy/green"
            begin=$SECONDS
        fi
        patched "$top/$file" > "$copy/tree/$file"
        changed=$file
        if ! ninja -C "$copy/tree/build" -j "$ninja_jobs" "$program" > "$log" 2>&1; then
            undecided "does not compile"; continue
        fi
        status=0; run_test "$copy" "$log" || status=$?
        if [ -n "$equivalent" ]; then
            if [ $status = 0 ]; then report "equivalent" $((SECONDS - begin))
            else report "killed though called equivalent" $((SECONDS - begin)); fi
        elif [ $status = 0 ]; then report "SURVIVED" $((SECONDS - begin))
        elif [ $status = 124 ] || [ $status = 137 ]; then report "killed (time limit)" $((SECONDS - begin))
        else report "killed" $((SECONDS - begin)); fi
    done < "$2"
    [ -z "$changed" ] || cp "$top/$changed" "$copy/tree/$changed"
    rm -rf "$copy/run"
}

shopt -s nullglob
lists=("$here"/*.txt)
[ ${#lists[@]} -gt 0 ] || { echo "mutants: no records in $here" >&2; exit 2; }
read_records "${lists[@]}" > "$work/records"
if [ -n "${ONLY:-}" ]; then
    awk -F "$separator" -v only="$ONLY" '($1 "/" $2) ~ only' "$work/records" > "$work/selected"
    mv "$work/selected" "$work/records"
fi
[ -s "$work/records" ] || { echo "mutants: no record matches ONLY=${ONLY:-}" >&2; exit 2; }

# Records that do not apply are reported, left out of the run, and make its status 1.
total=$(wc -l < "$work/records")
while IFS=$separator read -r module name file from to test equivalent; do
    if [ ! -f "$top/$file" ]; then echo "out of date: $module/$name: no file $file"; continue; fi
    n=$(occurrences "$top/$file")
    if [ "$n" != 1 ]; then echo "out of date: $module/$name: \"$from\" occurs $n times in $file, expected once"; continue; fi
    program=${test%% *}
    grep -rqE "vdbcloud_test\(${program#test_}\b" "$top/tests" --include=CMakeLists.txt ||
        { echo "out of date: $module/$name: no test program $program"; continue; }
    fields=("$module" "$name" "$file" "$from" "$to" "$test" "$equivalent")
    (IFS=$separator; printf '%s\n' "${fields[*]}") >&3
done < "$work/records" 3> "$work/applicable"
if [ -n "${CHECK:-}" ]; then
    echo "$(wc -l < "$work/applicable") of $total records apply"
    [ "$(wc -l < "$work/applicable")" = "$total" ]
    exit
fi

synchronise "$work/1/tree"
rm -f "$work"/*/green "$work"/todo.*
declare -A hash_of keys
index=0
while IFS=$separator read -r module name file from to test equivalent; do
    program=${test%% *}
    if [ -z "${hash_of[$program]:-}" ]; then
        sources=$(test_sources "$program")
        hash_of[$program]=$(cd "$top" && printf '%s\n' "$sources" | xargs cat | sha1sum)
    fi
    key=$({ printf '%s\n' "$name" "$file" "$from" "$to" "$test" "$equivalent" "${hash_of[$program]}"; cat "$top/$file"; } | sha1sum | cut -c 1-40)
    keys[$key]=1
    if ! grep -q "^$key" "$results"; then
        fields=("$key" "$module" "$name" "$file" "$from" "$to" "$test" "$equivalent")
        (IFS=$separator; printf '%s\n' "${fields[*]}") >> "$work/todo.$((index % copies + 1))"
        index=$((index + 1))
    fi
done < "$work/applicable"

echo "mutants: $total records, $index to run"
begin=$SECONDS
if [ $index -gt 0 ]; then
    mapfile -t programs < <(cut -d "$separator" -f 7 "$work"/todo.* | cut -d ' ' -f 1 | sort -u)
    NINJA_STATUS='building %f/%t ' ninja -C "$work/1/tree/build" -j "$jobs" "${programs[@]}" > "$work/build.log" 2>&1 ||
        { tail -n 30 "$work/build.log"; echo "mutants: the tree does not build without a fault" >&2; exit 1; }
fi
for list in "$work"/todo.*; do worker "${list##*.}" "$list" & done
wait
seconds=$((SECONDS - begin))

for key in "${!keys[@]}"; do grep -m 1 "^$key" "$results" || true; done | sort -t "$(printf '\t')" -k 4 > "$work/summary"
killed=$(awk -F '\t' '$2 == "killed" || $2 == "killed (time limit)"' "$work/summary" | wc -l)
equivalent=$(awk -F '\t' '$2 == "equivalent"' "$work/summary" | wc -l)
awk -F '\t' '$2 != "killed" && $2 != "killed (time limit)" && $2 != "equivalent" { print $2 ": " $4 }' "$work/summary"
echo "killed $killed of $total, equivalent $equivalent, $seconds seconds"
[ $((killed + equivalent)) = "$total" ]
