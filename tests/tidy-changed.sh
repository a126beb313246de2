#!/usr/bin/env bash
# clang-tidy on the sources that changed since a commit, and on the source of the same name for a header that changed.
# Usage: tidy-changed.sh BUILD JOBS [BASE]; BASE is where the branch left origin's default branch, else the last commit.
set -euo pipefail
build=$(cd "$1" && pwd) jobs=$2
cd "$(dirname "$0")/.."
base=${3:-$(git merge-base HEAD origin/HEAD 2> /dev/null || true)}
# A branch that equals its origin has one commit to look at: the last.
if [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD)" ]; then base=$(git rev-parse -q --verify HEAD~1 || git rev-parse HEAD); fi

# Sources of the build among the files that changed since $1. Only what the build compiles has a command for clang-tidy.
changed_since() {
    git diff --name-only --diff-filter=d "$1" -- '*.cc' '*.h' '*.inl' | sed 's/\.[a-z]*$/.cc/' | sort -u |
        while read -r file; do
            if grep -qF "/$file\"" "$build/compile_commands.json"; then echo "$file"; fi
        done
}

# A change of the whole tree is for `make -C tests tidy`: an hour's work has no place among the gates.
most=40
files=$(changed_since "$base")
if [ "$(wc -l <<< "$files")" -gt $most ]; then
    echo "clang-tidy: more than $most sources changed since $base: only those of the last commit are checked here"
    files=$(changed_since HEAD~1 | head -n $most)
fi
[ -n "$files" ] || exit 0
# clang cannot read the compiler's precompiled headers.
mkdir -p "$build/tidy"
sed -E 's/ -Winvalid-pch -include .*cmake_pch\.hxx(\\")?//' "$build/compile_commands.json" > "$build/tidy/compile_commands.json"
tr '\n' '\0' <<< "$files" | xargs -0 -r -n 1 -P "$jobs" clang-tidy -p "$build/tidy" --quiet --warnings-as-errors='*' 2> /dev/null
