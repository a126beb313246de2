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
{ ninja -C "$build" -j "$jobs" "$@" 2>&1 || echo $? > "$status"; } | {
    printed=0
    while IFS= read -r line; do
        case $line in
            'ninja: Entering directory '* | 'ninja: no work to do'*) ;;
            'building '*/*'  '*)
                count=${line#building } count=${count%%  *} done=${count%/*} total=${count#*/}
                if [ "$done" -lt "$printed" ]; then printed=0; fi  # the build was configured again
                if [ "$done" = "$total" ] || [ $((10 * (done - printed))) -ge "$total" ]; then
                    echo "building $count"
                    printed=$done
                fi ;;
            *) printf '%s\n' "$line" ;;
        esac
    done
}
[ ! -s "$status" ]
