# Functions of the families of benchmarks: rows of results from what the programs report. To be sourced by bash.

# cpu FILE...: processor seconds of runs, from their reports; the first number of that name is the whole run's.
cpu() { awk '$1 == "\"cpu_seconds\":" && !seen[FILENAME]++ { gsub(",", "", $2); sum += $2 } END { printf "%.2f", sum }' "$@"; }

# row CASE QUANTITY PLACE RUNG VOXEL OURS NOISE SECONDS: a line of results. NOISE is a standard error, 0 for none.
row() { local IFS=,; printf '%s\n' "$*"; }

# Of values by column, two numbers a line, "column value", means by every N columns, numbered from 1, and the mean of all.
# mean_rows CASE QUANTITY RUNG VOXEL N SECONDS COLUMNS: rows of the mean, and with COLUMNS of each column.
mean_rows() {
    awk -v start="$1,$2" -v end="$3,$4" -v n="$5" -v seconds="$6" -v columns="${7:-}" '
        { k = int($1 / n) + 1; sum[k] += $2; ++count[k]; all += $2; if (k > last) last = k }
        END {
            for (k = 1; columns != "" && k <= last; ++k) printf "%s,%d,%s,%.6g,0,%s\n", start, k, end, sum[k] / count[k], seconds
            printf "%s,mean,%s,%.6g,0,%s\n", start, end, all / NR, seconds
        }'
}

# map_rows CASE RUNG VOXEL N MU REPORT MAP [COLUMNS]: R, T and A of a periodic layer, from the map of p1solve --flux-map, over the
# flux MU of a sun of irradiance 1. A only where the medium absorbs. N and COLUMNS: as for mean_rows.
map_rows() {
    local seconds values
    seconds=$(cpu "$6")
    # oiiotool prints channels of files alone, and an .exr sorts them by name. Values: column, R, T, A.
    oiiotool "$7" --ch absorbed.R,diffuse_down.R,diffuse_up.R,direct_base.R -o "${7%.exr}.part.exr"
    values=$(oiiotool --dumpdata "${7%.exr}.part.exr" |
        awk -v mu="$5" '/Pixel/ { gsub("[(,]", "", $2); print $2, $6 / mu, ($5 + $7) / mu, $4 / mu }')
    awk '{ print $1, $2 }' <<< "$values" | mean_rows "$1" R "$2" "$3" "$4" "$seconds" "${8:-}"
    awk '{ print $1, $3 }' <<< "$values" | mean_rows "$1" T "$2" "$3" "$4" "$seconds" "${8:-}"
    awk '{ print $1, $4; sum += $4 } END { exit !(sum / NR > 1e-6) }' <<< "$values" > /dev/null || return 0
    awk '{ print $1, $4 }' <<< "$values" | mean_rows "$1" A "$2" "$3" "$4" "$seconds" "${8:-}"
}
