# Functions of the families of benchmarks: rows of results from what the programs report. To be sourced by bash.

# value KEY FILE: the first number called KEY in a report (--json), and 0 where there is none.
value() { awk -v key="\"$1\":" '$1 == key { gsub(",", "", $2); print $2; found = 1; exit } END { if (!found) print 0 }' "$2"; }

# cpu FILE...: processor seconds of all phases of reports, reading and writing included.
cpu() { awk '$1 == "\"cpu_seconds\":" { gsub(",", "", $2); sum += $2 } END { printf "%.2f", sum }' "$@"; }

# row CASE QUANTITY PLACE RUNG VOXEL OURS NOISE SECONDS: a line of results. NOISE is a standard error, 0 for none.
row() { local IFS=,; printf '%s\n' "$*"; }

# flux_rows CASE RUNG VOXEL INCIDENT REPORT: R, T and A of a periodic layer, from the report of p1solve. INCIDENT is the power
# of the sun on it. What is neither reflected nor absorbed leaves at the base, scattered or not.
flux_rows() {
    local reflected absorbed seconds
    reflected=$(value reflected "$5") absorbed=$(value absorbed "$5") seconds=$(cpu "$5")
    awk -v r="$reflected" -v a="$absorbed" -v in_="$4" -v start="$1" -v end="$2,$3" -v s="$seconds" 'BEGIN {
        r /= in_; a /= in_; if (a < 1e-9) a = 0
        printf "%s,R,mean,%s,%.6g,0,%s\n%s,T,mean,%s,%.6g,0,%s\n", start, end, r, s, start, end, 1 - r - a, s
        if (a > 0) printf "%s,A,mean,%s,%.6g,0,%s\n", start, end, a, s }'
}
