#!/bin/sh
# Builds targets and says how far it is: one line that changes on a terminal, a line each tenth elsewhere. Silent when
# nothing is out of date. Usage: ninja.sh BUILD JOBS TARGET...
set -eu
build=$1 jobs=$2
shift 2
if ninja -C "$build" -n "$@" | grep -q 'no work to do'; then exit 0; fi
export NINJA_STATUS='building %f/%t  '
if [ -t 1 ]; then exec ninja -C "$build" -j "$jobs" "$@"; fi

# A pipe hides the status of ninja, so a file keeps it.
status=$(mktemp)
trap 'rm -f "$status"' EXIT
{ ninja -C "$build" -j "$jobs" "$@" 2>&1 || echo $? > "$status"; } | awk '
    /^ninja: (Entering directory|no work to do)/ { next }
    /^building [0-9]+\/[0-9]+  / {
        split($2, n, "/")
        if (n[1] < printed) printed = 0  # the build was configured again
        if (n[1] == n[2] || n[1] - printed >= n[2] / 10) { print "building " $2; fflush(); printed = n[1] }
        next
    }
    { print; fflush() }'
[ ! -s "$status" ]
