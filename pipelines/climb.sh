#!/usr/bin/env bash
# The cheapest rung (data/rungs.txt) whose picture holds an error. rules.mk calls it for `make ERROR=2%`.
#
#   climb.sh MAKE BIN OUT NAME ERROR TIME
#
#   MAKE BIN OUT   make, the folder of the programs and OUT, as rules.mk has them; a rung's files go to OUT/rungN
#   NAME           of the picture: OUT/NAME.exr and OUT/NAME.png become those of the rung that holds
#   ERROR          bound of the root mean square error over blocks of 32 x 32 pixels, relative to the mean: 2%
#   TIME           seconds of the clock for all tries
#
# A rung holds if the upper end of the interval of its certificate (render --certify) is at or below ERROR. A certificate takes
# as long as the picture, and twice as long again and again while its interval contains ERROR. Whole light paths have no
# bias, so the standard error of their blocks stands for the certificate. An interval that one path's light makes unreliable
# ends no climb: it takes more time. Files that are up to date are taken as they are.
# Status: 0 done; 1 a program failed; 2 usage; 3 TIME ended first.
set -euo pipefail
make=$1 bin=$2 out=$3 name=$4 error=$5 time=$6
top=$(cd "$(dirname "$0")/.." && pwd)
table=$top/data/rungs.txt
fail() { echo "climb.sh: $2" >&2; exit "$1"; }
[[ $error =~ ^[0-9]*\.?[0-9]+%$ ]] || fail 2 "ERROR = '$error': expected a bound of the error in percent, such as 2%"
[[ $time =~ ^[0-9]*\.?[0-9]+$ ]] || fail 2 "TIME = '$time': expected seconds, such as 600"
target=${error%\%}
awk -v t="$target" -v s="$time" 'BEGIN { exit !(t > 0 && s > 0) }' || fail 2 "ERROR = '$error', TIME = '$time': expected numbers above 0"
"$bin/render" --help | grep -e --certify > /dev/null || fail 2 "$bin/render measures no errors (no option --certify): give RUNG, or BIN of a newer build"
calc() { awk "BEGIN { printf \"%.6g\", ($1) }"; }
holds() { awk "BEGIN { exit !($1) }"; }
begin=$(date +%s.%N)
left() { calc "$time - ($(date +%s.%N) - $begin)"; }
# value OPTION RUNG: of the table.
value() { awk -v option="$1" -v n="$2" '$2 == option { print $(n + 3) }' "$table"; }
# member FILE OBJECT KEY: a number of a report, in an object; OBJECT may be a . for the first key of that name.
member() {
    awk -v object="\"$2\":" -v key="\"$3\":" '
        $1 == object { inside = 1 }
        (inside || object == "\".\":") && $1 == key { sub(/,$/, "", $2); print $2; exit }' "$1"
}

# picture RUNG FLAGS: makes OUT/rungN/NAME.exr and .json.
picture() {
    local status=0 seconds
    seconds=$(left)
    holds "$seconds > 0" || return 124
    timeout "$seconds" "$make" --no-print-directory -s PLACED=1 BIN="$bin" OUT="$out/rung$1" RUNG="$1" ERROR= climb_flags="$2 --json $out/rung$1/$name.json" \
        "$out/rung$1/$name.exr" > "$out/rung$1/$name.log" 2>&1 || status=$?
    [ $status = 0 ] || [ $status = 124 ] || { cat "$out/rung$1/$name.log" >&2; fail 1 "rung $1 failed"; }
    return $status
}
seconds_of() { cat "$out/rung$1/$name".*.seconds | awk '{ s += $1 } END { printf "%.1f", s }'; }

# try RUNG: sets low and high [%], the interval of the error.
try() {
    local folder=$out/rung$1 flags half seconds noise
    mkdir -p "$folder"
    [ -s "$folder/$name.json" ] || rm -f "$folder/$name.exr"
    if [ "$(value --integrator "$1")" = path ] && [ "$(value --gather "$1")" = - ]; then
        # Noise of a block of 32 x 32 pixels is a 32nd of a pixel's; a quarter of the bound is room for its own error.
        picture "$1" "--noise $(calc "0.01 * $target * 32 * 0.75") --time-limit $(left)" || return 124
        noise=$(member "$folder/$name.json" accuracy noise)
        error_of_rung=$(calc "100 * $noise / 32") low=0
        high=$(calc "$error_of_rung * 4 / 3")
        return 0
    fi
    half=$(calc "$target / 4") seconds=2
    while :; do
        flags="--certify $half%,$(calc "$seconds < $(left) ? $seconds : $(left)")"
        picture "$1" "$flags" || return 124
        [ -n "$(member "$folder/$name.json" rms_32x32 high)" ] || fail 1 "rung $1: $folder/$name.json has no certificate"
        low=$(calc "100 * $(member "$folder/$name.json" rms_32x32 low)")
        high=$(calc "100 * $(member "$folder/$name.json" rms_32x32 high)")
        error_of_rung=$(calc "100 * $(member "$folder/$name.json" rms_32x32 value)")
        reliable=$(member "$folder/$name.json" certificate reliable)
        # Too bright a path makes an interval that cannot be relied on: it may not end the climb.
        if holds "$low > $target"; then return 0; fi
        if [ "$reliable" != false ] && holds "$high <= $target || $high - $low <= 2 * $half"; then return 0; fi
        holds "$(left) > 0" || return 124
        [ "$reliable" != false ] || half=$(calc "$half / 2")
        seconds=$(calc "2 * $seconds > $(seconds_of "$1") ? 2 * $seconds : $(seconds_of "$1")")
        rm -f "$folder/$name.exr"
    done
}

printf '%s: error over 32x32 pixels at most %s, %s s at most\n' "$name" "$error" "$time"
printf '%5s  %-24s %9s  %s\n' rung 'error [%], 95 %' seconds 'the step bought'
before= before_seconds=0 last=
for rung in $(sed -n 's/^rung \([0-9]*\):.*/\1/p' "$table"); do
    if ! try "$rung"; then
        echo "$name: the time ended on rung $rung${last:+; the best picture is $(realpath -s -- "$out/rung$last/$name.png")}" >&2
        exit 3
    fi
    seconds=$(seconds_of "$rung")
    bought=
    [ -z "$before" ] || bought=$(awk -v a="$before" -v b="$error_of_rung" -v s="$seconds" -v t="$before_seconds" 'BEGIN {
        printf "  %.3g %% to %.3g %% for %.1f s more", a, b, s - t }')
    printf '%5s  %-24s %9s%s\n' "$rung" "$(awk -v v="$error_of_rung" -v l="$low" -v h="$high" 'BEGIN { printf "%.3g (%.3g to %.3g)", v, l, h }')" \
        "$seconds" "$bought"
    last=$rung before=$error_of_rung before_seconds=$seconds
    if holds "$high <= $target"; then
        for kind in exr png json; do
            cp -f "$out/rung$rung/$name.$kind" "$out/.$name.part.$kind"
            mv -f "$out/.$name.part.$kind" "$out/$name.$kind"
        done
        echo "$name: rung $rung holds $error"
        realpath -s -- "$out/$name.png"
        exit 0
    fi
done
echo "$name: no rung holds $error in $time s; the best picture is $(realpath -s -- "$out/rung$last/$name.png")" >&2
exit 3
