#!/usr/bin/env bash
# README and docs/*.md name only what exists: options, files, modules, grids and metadata, make targets, tests and test
# programs. Usage: documents.sh BIN, the folder of the built programs.
set -euo pipefail
bin=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."
programs=$(sed -n 's/^foreach(app common \(.*\) vdbcloud)$/\1/p' apps/CMakeLists.txt)
[ -n "$programs" ] || { echo "documents.sh: apps/CMakeLists.txt does not list the programs as expected" >&2; exit 1; }

# Code of the documents, one piece a line: "FILE:LINE<tab>CODE". Pieces are `spans`, and lines set off by four blanks.
pieces() {
    awk '
        FNR == 1 { fenced = 0 }
        /^```/ { fenced = !fenced; next }
        fenced || /^    [^ ]/ { text = $0; sub(/^ +/, "", text); sub(/ +#.*/, "", text); print FILENAME ":" FNR "\t" text; next }
        {
            n = split($0, part, "`")
            for (i = 2; i <= n; i += 2) if (i < n) print FILENAME ":" FNR "\t" part[i]
            while (match($0, /\]\([^)]*\)/)) {  # the targets of links
                target = substr($0, RSTART + 2, RLENGTH - 3); $0 = substr($0, RSTART + RLENGTH)
                if (target !~ /^https?:/) print FILENAME ":" FNR "\t" target
            }
        }' README.md docs/*.md
}

options_of() { "$bin/$1" --help-all | grep -oE '(^|[ ,])--[a-z][a-z0-9-]*' | tr -d ' ,' | sort -u; }
declare -A options
for program in $programs; do options[$program]=$(options_of "$program"); done
every_option=$(printf '%s\n' "${options[@]}")
tests=$(sed -n 's/^TEST\(_F\|_P\)\?(\([A-Za-z0-9_]*\), *\([A-Za-z0-9_]*\)).*/\2.\3/p' tests/*/*.cc)

bad=0
complain() { echo "$where: $*" >&2; bad=1; }

# check_options PROGRAM CODE: the options of one command, up to its pipe or comment.
check_options() {
    local known=$every_option option
    [ -z "$1" ] || known=${options[$1]}
    for option in $(grep -oE '(^| )--[a-z][a-z0-9-]*' <<< "$2" || true); do
        grep -qxF -e "$option" <<< "$known" || complain "${1:-no program} has no option $option"
    done
}

# The targets of a folder's Makefile, as make knows them.
declare -A targets
for folder in pipelines tests; do
    targets[$folder]=$({ make -C "$folder" -npq .none 2> /dev/null || true; } | sed -n 's/^\([a-z][a-z0-9-]*\):.*/\1/p' | tr '\n' ' ')
done

check_command() {
    local command=$1 words
    read -ra words <<< "$command"
    [ ${#words[@]} -gt 0 ] || return 0
    [ "${words[0]}" != vdbcloud ] || words=("${words[@]:1}")
    case ${words[0]:-} in
    make)
        case "${words[1]:-} ${words[2]:-}" in
        "-C pipelines" | "-C tests")
            local word
            for word in "${words[@]:3}"; do
                [[ $word == *=* || $word == \[* || " ${targets[${words[2]}]} " == *" $word "* ]] ||
                    complain "${words[2]}/Makefile has no target $word"
            done;;
        esac;;
    cmake | ctest | git | gnuplot | ninja | apt* | export | PATH=* | SIZE=* | build/bin/test_*) ;;
    --*) check_options "" "$command";;
    *) if [[ -n ${words[0]:-} && " $programs " == *" ${words[0]} "* ]]; then check_options "${words[0]}" "$command"; fi;;
    esac
}

check_names() {
    local word
    for word in $(tr -s " ,;()'\"=|>" '\n' <<< "$1"); do
        word=${word%[.:]}
        case $word in
        build/* | *'<'* | *'*'* | *'%'* | path/* | http*) ;;
        docs/?* | apps/?* | libvdbcloud/?* | tests/?* | data/?* | pipelines/?* | cmake/?* | .ci/?*)
            [ -e "$word" ] || complain "no file $word";;
        *.h | *.cc)
            if [[ $word == */* ]]; then
                [ -e "$word" ] || [ -e "libvdbcloud/vdbcloud/$word" ] || complain "no file $word"
            fi;;
        [a-z]*/)
            [ -d "$word" ] || [ -d "libvdbcloud/vdbcloud/$word" ] || complain "no folder $word";;
        packages.txt | *.md | *.cff) [ -e "$word" ] || complain "no file $word";;
        bench_[a-z]*) grep -qwE "${word#bench_}|$word" tests/bench/CMakeLists.txt || complain "no benchmark $word";;
        test_[a-z]*) grep -rqE "vdbcloud_test\(${word#test_}\b" tests --include=CMakeLists.txt || complain "no test program $word";;
        vdb_* | lib*-dev) ;;  # programs of OpenVDB, packages of Debian
        vdbcloud:?*) grep -rqF -e "\"$word\"" -e "\"${word#vdbcloud:}\"" libvdbcloud apps || complain "the sources have no metadata $word";;
        esac
        if [[ $word =~ ^[a-z]+(_[a-z0-9]+)+$ && ! $word =~ ^(vdb|bench|test)_ ]]; then
            grep -rqwF "$word" libvdbcloud apps || complain "the sources have no grid, key or name $word"
        fi
        if [[ $word =~ ^[A-Z][A-Za-z0-9]+\.[A-Z][A-Za-z0-9]+\*?$ ]]; then
            grep -qE "^${word%\*}$([[ $word == *\* ]] || echo '$')" <<< "$tests" || complain "no test $word"
        fi
    done
}

while IFS=$'\t' read -r where code; do
    while read -r command; do check_command "$command"; done < <(sed 's/ *| */\n/g; s/ *&& */\n/g' <<< "$code")
    check_names "$code"
done < <(pieces)

# Each program has a line in README's table.
where=README.md
for program in $programs; do grep -q "^| \`$program\` |" README.md || complain "the table of programs lacks $program"; done
exit $bad
