#!/usr/bin/env bash
# Runs a command of a pipeline, first with --dry-run and then in earnest, and appends to the file SAID: a line "run" with
# program, output, seconds and bytes said and taken, and a line "event" for each event with its count said and taken ("-":
# not counted by the run). Use it as LAUNCH of a pipeline: make -C pipelines/cumulus LAUNCH=tests/bench/said_and_taken.sh
set -euo pipefail
: "${SAID:?expected the file to append to}"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for ((n = 1; n < $#; ++n)); do [ "${!n}" != -o ] || { k=$((n + 1)); output=${!k##*/}; }; done
case ${1##*/} in
fractalgen | illuminate | p1solve | render | cloudsim | vdbimport | exrmerge) ;;
*) exec "$@" ;;
esac
"$@" --dry-run --json "$folder/said" > "$folder/plan"
"$@" --json "$folder/taken"
awk -v program="${1##*/}" -v output="${output:-}" '
    FNR == 1 { ++file }
    { value = $2; sub(/,$/, "", value); name = $1; gsub(/[":]/, "", name) }
    /^  "estimate": {/ { inside = "estimate" }
    /^    "events": {/ && inside == "estimate" { events = 1 }
    /^  "events": {/ { inside = "events"; events = 1 }
    /^    }/ || /^  }/ { events = 0 }
    /^  }/ { inside = "" }
    events && NF == 2 && value ~ /^[0-9]/ { if (file == 1) said[name] = value; else taken[name] = value; seen[name] = 1 }
    file == 1 && inside == "estimate" && /^    "seconds"/ { seconds = value }
    file == 1 && inside == "estimate" && /^    "memory_bytes"/ { bytes = value }
    file == 2 && /^  "cpu_seconds"/ { cpu = value }
    file == 2 && /^  "peak_memory_bytes"/ { peak = value }
    END {
        print "run", program, output, seconds, cpu, bytes, peak
        for (name in seen)
            print "event", program, output, name, name in said ? said[name] : 0, name in taken ? taken[name] : "-"
    }' "$folder/said" "$folder/taken" >> "$SAID"
