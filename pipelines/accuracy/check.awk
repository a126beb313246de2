# Whether the studies hold what theory says: awk -f check.awk studies.txt table.csv. A sentence for each that does not; status 1.
#
#   Orders: the slope of log(error) against log(x), fitted to the points of a method that lie above the floor, is within the
#   bounds of "order" in studies.txt. Errors below the floor of the study are those of half floats in pictures.
#   Prices: a point errs by at most 1.2 times the cheaper one before it, or is below what the reference can tell.
BEGIN { FS = "," }
FNR == 1 { ++file }
file == 1 && /^study / { study = $0; sub(/^study /, "", study); sub(/:.*/, "", study) }
file == 1 && /^floor / { split($0, word, " "); known_floor[study] = word[2] }
file == 1 && /^order / {
    n = split($0, word, " ")
    method = word[2]; for (k = 3; k <= n - 2; ++k) method = method " " word[k]
    least[study, method] = word[n - 1]; most[study, method] = word[n]
}
file == 1 || $1 == "study" { next }
{
    curve = $1 "," $2 "," $3
    if (!(curve in size)) curves[++count] = curve
    k = ++size[curve]; at[curve, k] = $5; error[curve, k] = $6; low[curve, k] = $7; setting[curve, k] = $4
    if (k > 1 && $6 > 1.2 * error[curve, k - 1] && $7 > 0 && $6 > floor_of($1) && $7 > 1.2 * high_of[curve, k - 1])
        complain($4 " errs by " $6 " %, " setting[curve, k - 1] ", which is cheaper, by " error[curve, k - 1] " %")
    high_of[curve, k] = $8
}
END {
    for (c = 1; c <= count; ++c) {
        curve = curves[c]
        split(curve, part, ",")
        key = part[1] SUBSEP part[3]
        if (!(key in least)) continue
        m = sx = sy = sxx = sxy = 0
        for (k = 1; k <= size[curve]; ++k) {
            if (error[curve, k] < floor_of(part[1]) || low[curve, k] == 0 || at[curve, k] == "-") continue
            x = log(at[curve, k]); y = log(error[curve, k])
            ++m; sx += x; sy += y; sxx += x * x; sxy += x * y
        }
        if (m < 2) { complain("fewer than two points of order are above " floor_of(part[1]) " %"); continue }
        slope = (m * sxy - sx * sy) / (m * sxx - sx * sx)
        ++orders
        printf "order,%s,%.2f,%s,%s\n", curve, slope, least[key], most[key]
        if (slope < least[key] || slope > most[key]) complain("the error falls with order " sprintf("%.2f", slope) ", expected " least[key] " to " most[key])
    }
    if (!orders) { print "check.awk: no orders in the table" > "/dev/stderr"; bad = 1 }
    exit bad
}
# Half floats leave 0.003 % of a block's mean; orders are read well above that.
function floor_of(s) { return s in known_floor ? known_floor[s] : 0.02 }
function complain(text,    part) {
    split(curve, part, ",")
    print "check.awk: " part[1] ", " part[2] ", " part[3] ": " text > "/dev/stderr"
    bad = 1
}
