#!/usr/bin/env bash
# clang-tidy on the sources that changed since a commit, and on the source of the same name for a header that changed.
# Usage: tidy-changed.sh BUILD JOBS [BASE]; BASE is where the branch left origin's default branch, else the last commit.
set -euo pipefail
build=$(cd "$1" && pwd) jobs=$2
cd "$(dirname "$0")/.."
base=${3:-$(git merge-base HEAD origin/HEAD 2> /dev/null || true)}
# A branch that equals its origin has one commit to look at: the last.
if [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD)" ]; then base=$(git rev-parse -q --verify HEAD~1 || git rev-parse HEAD); fi

git diff --name-only --diff-filter=d "$base" -- '*.cc' '*.h' '*.inl' | sed 's/\.[a-z]*$/.cc/' | sort -u |
    while read -r file; do
        # Only what the build compiles has a command that clang-tidy can follow.
        if grep -qF "/$file\"" "$build/compile_commands.json"; then printf '%s\0' "$file"; fi
    done | xargs -0 -r -n 1 -P "$jobs" clang-tidy -p "$build" --quiet --warnings-as-errors='*' 2> /dev/null
