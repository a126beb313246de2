#!/usr/bin/env bash
# One study of studies.txt: its rows as .csv on standard output.
# Usage: study.sh BIN FOLDER STUDY small|default|full [STAMP]; needs oiiotool, vdb_print, awk, xargs.
#
#   study,case,method,setting,x,error,low,high,mean,seconds,megabytes
#
# error, its 95 % interval and the mean error are in percent; seconds are processor time of the programs that the study costs;
# megabytes is the file that the picture is made of. error: of pictures, root mean square over blocks of 8 x 8 pixels, relative to the mean
# of the reference; its noise is taken off, so that an error below it has a low of 0.
#
# FOLDER keeps every file, named by the digest of STAMP and of the commands that made it, and every row, named by that of the
# commands and of this file: a study that was stopped goes on.
set -euo pipefail
shopt -s inherit_errexit
bin=$(cd "$1" && pwd)
mkdir -p "$2"
study=$3 size=$4 stamp=${5:-}
here=$(cd "$(dirname "$0")" && pwd)
source "$here/../benchmarks/rows.sh"
source "$here/../benchmarks/views.sh"
measure=$(sha1sum < "$here/study.sh")
# Names in commands are relative, for any name that the folder may have.
cd "$2"
fail() { echo "study.sh: $study: $*" >&2; exit 1; }

# The study's lines at this size, without "more" and "full": KIND, and the columns between tabs.
lines=$(awk -v study="$study" -v size="$size" '
    BEGIN { level = size == "small" ? 1 : size == "full" ? 3 : 2 }
    /^#/ || NF == 0 { next }
    $1 == "study" { inside = $2 == study ":"; next }
    !inside { next }
    {
        if ($1 ~ /^more/) { if (level < 2) next; sub(/^more-case/, "case"); sub(/^more/, "point") }
        if ($1 ~ /^full/) { if (level < 3) next; sub(/^full/, "point") }
        while (match($0, /@[^ \/]*\/[^ \/]*\/[^ \/]*/)) {
            split(substr($0, RSTART + 1, RLENGTH - 1), value, "/")
            $0 = substr($0, 1, RSTART - 1) value[level] substr($0, RSTART + RLENGTH)
        }
        kind = $1; sub(/^[^ ]+ */, "")
        gsub(/ *\| */, "\t"); print kind "\t" $0
    }' "$here/studies.txt")
[ -n "$lines" ] || fail "no such study in studies.txt"
of_kind() { awk -F '\t' -v kind="$1" '$1 == kind { sub(/^[^\t]*\t/, ""); print }' <<< "$lines"; }
column() { awk -F '\t' -v n="$2" '{ print $n }' <<< "$1"; }
costs=$(of_kind costs)
reference=$(of_kind reference)
grid=$(of_kind cloudsim)

key() { sha1sum <<< "$stamp $*" | cut -c 1-16; }
# made PROGRAM FLAGS INPUT KIND: sets $file, of that kind, and $report, from files that are there or by the program.
made() {
    local name=files/$1.$(key "$1 $2 $3")
    file=$name.$4 report=$name.json
    [ ! -e "$report" ] || return 0
    mkdir -p files
    local words=()
    mapfile -t words < <(xargs -n 1 printf '%s\n' <<< "$2")
    if [ "$1" = make_cloud ]; then
        "$bin/make_cloud" "${words[@]}" "$file" && echo '{}' > "$report.part"
    else
        local status=0
        "$bin/$1" --quiet ${3:+"$3"} "${words[@]}" --json "$report.part" -o "$file" 2> "$name.log" || status=$?
        [ $status = 0 ] || { cat "$name.log" >&2; fail "$1 $2 ended with status $status"; }
    fi
    mv "$report.part" "$report"
}
# merged WORDS...: the options of all, the last of each, so that a point's value takes the place of the case's.
merged() {
    xargs -n 1 printf '%s\n' <<< "$*" | awk '
        /^--/ { at = $0; sub(/=.*/, "", at); if (!(at in seen)) { seen[at] = 1; order[++n] = at } text[at] = $0; next }
        !n { print; next }  # a program and its words
        { text[at] = text[at] " " $0 }
        END { for (k = 1; k <= n; ++k) print text[order[k]] }' | xargs
}
# chain DENSITY ILLUMINATE P1SOLVE RENDER: sets $solved, the file to draw, $drawn, options of render, and $reports by program: their names, blanks between.
declare -A reports
chain() {
    local density=$1
    reports=()
    made "${density%% *}" "${density#* }" "" vdb
    solved=$file reports[density]=$report
    if [ -n "$2" ] && [[ $2 != *none ]]; then made illuminate "$2" "$solved" vdb; solved=$file reports[illuminate]=$report; fi
    if [ -n "$3" ] && [[ $3 != *none ]]; then made p1solve "$3" "$solved" vdb; solved=$file reports[p1solve]=$report; fi
    drawn=$4
}
# blocks FILE ...: "i,j luminance" of each block of 8 x 8 pixels; of several files "n,i,j luminance", n from 1. oiiotool takes longer
# to start than to print: one for all.
blocks() {
    oiiotool --dumpdata "$@" | awk -F '[(,): ]+' -v files=$# '
        !/^ *Pixel/ { ++n; next }
        { sum[(files > 1 ? n "," : "") int($3 / 8) "," int($4 / 8)] += (0.2126 * $5 + 0.7152 * $6 + 0.0722 * $7) / 64 }
        END { for (k in sum) printf "%s %.9g\n", k, sum[k] }' | sort
}
# error_of TRUTH FOUND: "error low high mean" in percent, of lines "place value [standard error]" and "place value". Places that are
# 0 in both see no medium, and do not count.
error_of() {
    awk '
        NR == FNR { truth[$1] = $2; noise[$1] = $3 + 0; mean += $2; next }
        $2 == 0 && truth[$1] == 0 { next }  # sees nothing
        { d = $2 - truth[$1]; ++n; sum += d; square += d * d; s = noise[$1] * noise[$1]; taken += s; spread += 2 * s * s + 4 * d * d * s; if (!($1 in truth)) exit bad = 1 }
        END {
            if (bad || !n || mean == 0) { print "study.sh: no values to compare" > "/dev/stderr"; exit 1 }
            mean /= n; e = (square - taken) / n; w = 1.96 * sqrt(spread) / n
            printf "%.6g %.6g %.6g %.6g\n", 100 * root(e) / mean, 100 * root(e - w) / mean, 100 * root(e + w) / mean, 100 * sum / n / mean
        }
        function root(x) { return x > 0 ? sqrt(x) : 0 }' "$1" "$2"
}
seconds_of() {
    local program taken=()
    for program in $costs; do taken+=(${reports[$program]:-}); done
    # A certificate is no part of its picture.
    awk '
        FNR == 1 { whole = 0; inside = 0 }
        $1 == "\"certificate\":" { inside = 1 }
        $1 == "\"cpu_seconds\":" { sub(/,$/, "", $2); if (inside) { sum -= $2; inside = 0 } else if (!whole) { sum += $2; whole = 1 } }
        END { printf "%.3f", sum }' "${taken[@]}"
}

# Pictures against that of the reference.
of_picture() {
    local truth=files/truth.$(key "$measure $1 $reference") all
    if [ ! -e "$truth" ]; then
        all=$(compose "$1" "$reference")
        chain_of "$all"
        made render "$drawn" "$solved" exr
        blocks "$file" > "$truth.part"
        mv "$truth.part" "$truth"
    fi
    chain_of "$2"
    made render "$drawn" "$solved" exr
    reports[render]=$report
    blocks "$file" > found
    error_of "$truth" found
}
# Three views of the cloud of puffs against data/references/puffs.txt, as docs/scattering.md has them.
of_puffs() {
    local name camera turn drawings= views=()
    chain_of "$2"
    while read -r name camera turn; do
        made render "$drawn ${cube_camera[*]} --camera $camera --resolution 24 --aov none" "$solved" exr
        drawings+=" $report"
        views+=("$file")
    done < <(cube_views)
    blocks "${views[@]}" | awk -v views="$(cube_views | cut -d ' ' -f 1,3 | xargs)" "$cube_place"'
        BEGIN { split(views, word, " ") }
        { split($1, k, ","); at = cube_place(word[2 * k[1]], k[2], k[3], 2); sub(/ /, ",", at); print word[2 * k[1] - 1] "," at, $2 }' > found
    reports[render]=$drawings
    awk -v medium="$1" '$1 " " $2 " " $3 == medium { print $4 "," $5 "," $6, $7, $8 }' "$here/../../data/references/puffs.txt" > truth
    # Each view counts the same: all values over the mean of the true view.
    awk '
        FILENAME == "truth" && !again { split($1, k, ","); mean[k[1]] += $2; ++n[k[1]]; next }
        { again = 1; split($1, k, ","); m = mean[k[1]] / n[k[1]]; $2 /= m; if (NF > 2) $3 /= m; print > (FILENAME ".views") }' truth found truth
    error_of truth.views found.views
}
# A picture against light paths, by its own certificate; its errors in false colours.
of_certificate() {
    local shown
    shown=pictures/$(tr -cs 'A-Za-z0-9.\n' - <<< "$study-$3")
    chain_of "$2"
    mkdir -p pictures
    made render "$drawn --png $shown.png --error-png $shown.errors.png" "$solved" exr
    reports[render]=$report
    awk '$1 == "\"error_png_limit\":" { sub(/,$/, "", $2); printf "%.3g\n", 100 * $2 }' "$report" > "$shown.limit"
    awk '$1 == "\"mean\":" { of = "mean" } $1 == "\"rms_8x8\":" { of = "rms" } $1 == "\"rms_32x32\":" { of = "" }
        of { key = $1; gsub(/[":]/, "", key); sub(/,$/, "", $2); if (key ~ /^(value|low|high)$/) v[of, key] = 100 * $2 }
        END {
            if (!(("rms", "value") in v) || !(("mean", "value") in v)) exit 1
            printf "%.6g %.6g %.6g %.6g\n", v["rms", "value"], v["rms", "low"], v["rms", "high"], v["mean", "value"]
        }' "$report" || fail "$report has no certificate"
}
# compose CASE POINT: the options of a case with those of a point (or of the reference), column by column.
compose() {
    local k out=()
    for k in 1 2 3 4; do out[k]=$(merged "$(column "$1" $((k + 1)))" "$(column "$2" $((k + ${3:-1})))"); done
    (IFS=$'\t'; printf '%s\n' "${out[*]//%/$(column "$1" 1)}")
}
chain_of() { chain "$(column "$1" 1)" "$(column "$1" 2)" "$(column "$1" 3)" "$(column "$1" 4)"; }

# profile FILE: "place value" at the cells' centres of a run of cloudsim. Leaves cells and spacing in the file box.
profile() {
    vdb_print -l "$1" | sed -n 's/^cloudsim:parameters: cells = //p; s/^spacing = //p' | head -2 | xargs | tr ',' ' ' > box
    awk '{ for (k = 0; k < $3; ++k) for (j = 0; j < $2; ++j) for (i = 0; i < $1; ++i)
             printf "%.9g %.9g %.9g\n", (i + 0.5 - $1 / 2) * $4, (k + 0.5) * $6, (j + 0.5 - $2 / 2) * $5 }' box > points
    "$bin/vdbprobe" "$1" --grid "$grid" --points points | awk -v box="$(< box)" '
        BEGIN { split(box, n, " ") } /^#/ { next }
        { c = NR - 2; i = c % n[1]; j = int(c / n[1]) % n[2]; print i "," j "," int(c / n[1] / n[2]), $4 }'
}
of_cloudsim() {
    local all truth fine=files/fine.$(key "$measure $1 $reference")
    all=$(merged "$(column "$1" 2)" "$reference")
    if [ ! -e "$fine" ]; then
        made cloudsim "$all --unpruned --every $(every "$all")" "" vdb
        profile "$file" > "$fine.part"
        cp box "$fine.box"
        mv "$fine.part" "$fine"
    fi
    all=$(merged "$(column "$1" 2)" "$(column "$2" 4)")
    made cloudsim "$all --unpruned --every $(every "$all")" "" vdb
    reports=([cloudsim]=$report) solved=$file
    profile "$file" > found
    # Means of the fine cells in each coarse one, and the deviations from the mean of a level.
    awk -v from="$(< "$fine.box")" -v to="$(< box)" '
        BEGIN { split(from, f, " "); split(to, t, " "); for (a = 1; a <= 3; ++a) r[a] = f[a] / t[a] }
        { split($1, c, ","); k = int(c[1] / r[1]) "," int(c[2] / r[2]) "," int(c[3] / r[3]); sum[k] += $2; ++n[k] }
        END { for (k in sum) printf "%s %.9g\n", k, sum[k] / n[k] }' "$fine" > truth
    awk '
        { split($1, c, ","); level = c[3] }
        NR == FNR { truth[$1] = $2; sum[level] += $2; ++n[level]; next }
        { d = $2 - truth[$1]; m = truth[$1] - sum[level] / n[level]; square += d * d; all += m * m; mean += d; spread += m < 0 ? -m : m; ++count }
        END {
            if (!count || all == 0) exit 1
            e = 100 * sqrt(square / all); printf "%.6g %.6g %.6g %.6g\n", e, e, e, 100 * mean / spread
        }' truth found
}
every() { sed -n 's/.*--minutes \([0-9.]*\).*/\1min/p' <<< "$1"; }

while IFS= read -r case_; do
    name=$(column "$case_" 1)
    while IFS= read -r point; do
        method=$(column "$point" 1) setting=$(column "$point" 2) x=$(column "$point" 3)
        [[ $name =~ $(column "$point" 8) ]] || continue
        row=rows/$(key "$measure $study $case_ $point $reference $costs")
        if [ ! -e "$row" ]; then
            mkdir -p rows
            if [ -n "$grid" ]; then error=$(of_cloudsim "$case_" "$point"; seconds_of; stat -L -c ' %s' "$solved")
            else
                composed=$(compose "$case_" "$point" 3)
                case $reference in
                puffs) error=$(of_puffs "$name" "$composed"; seconds_of; stat -L -c ' %s' "$solved") ;;
                certificate) error=$(of_certificate "$case_" "$composed" "$name-$method-$setting"; seconds_of; stat -L -c ' %s' "$solved") ;;
                *) error=$(of_picture "$case_" "$composed"; seconds_of; stat -L -c ' %s' "$solved") ;;
                esac
            fi
            read -r error low high mean seconds bytes <<< "$(xargs <<< "$error")"
            row "$study" "$name" "${method//,/}" "$setting" "$x" "$error" "$low" "$high" "$mean" "$seconds" \
                "$(awk -v b="$bytes" 'BEGIN { printf "%.3g", b / 1e6 }')" > "$row.part"
            mv "$row.part" "$row"
            echo "  $study: $name, $method, $setting: $error % in $seconds s" >&2
        fi
        cat "$row"
    done < <(of_kind point)
done < <(of_kind case)
