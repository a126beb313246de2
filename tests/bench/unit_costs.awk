# Unit costs >= 0 by least squares of (sum of counts times costs) / seconds - 1, by coordinate descent, program by program.
# Reads what said_and_taken.sh wrote, then the table, and prints the table with new costs. Counts are those taken where the
# run has them, else those said. A weak term holds costs near the table's where events come together in all commands, and
# a cost that no command shows keeps its value.
BEGIN { weak = 0.001 }
FILENAME == ARGV[1] {
    if ($1 == "run") { r = ++runs; program[r] = $2; seconds[r] = $5; next }
    count[r, $4] = $6 == "-" ? $5 : $6
    events[$4] = 1
    next
}
{ line[++lines] = $0; if ($2 ~ /^[0-9.e+-]+$/ && $3 == "#") prior[$1] = cost[$1] = $2 * 1e-9 }
# Costs that all programs share come from those that read and write most: illuminate and p1solve.
function fit(wanted, fixed,   sweep, e, r, top, bottom, part, rest) {
    for (sweep = 0; sweep < 3000; ++sweep)
        for (e in cost) {
            if (e in fixed) continue
            shown = 0
            top = prior[e] > 0 ? weak / prior[e] : 0
            bottom = prior[e] > 0 ? weak / prior[e] ^ 2 : 0
            for (r = 1; r <= runs; ++r) {
                if (!(program[r] in wanted) || !count[r, e]) continue
                part = count[r, e] / seconds[r]
                rest = 1 - predicted[r] / seconds[r] + cost[e] * part
                top += part * rest
                bottom += part * part
                shown = 1
            }
            if (!shown) continue
            new = top / bottom > 0 ? top / bottom : 0
            for (r = 1; r <= runs; ++r) if (count[r, e]) predicted[r] += (new - cost[e]) * count[r, e]
            cost[e] = new
        }
}
END {
    for (r = 1; r <= runs; ++r) for (e in cost) predicted[r] += count[r, e] * cost[e]
    split("", fixed)
    split("", some); some["fractalgen"]; some["illuminate"]; some["p1solve"]
    fit(some, fixed)
    fixed["read_byte"]; fixed["write_byte"]; fixed["light_point"]; fixed["lattice_product"]; fixed["exact_cell"]
    split("render cloudsim vdbimport exrmerge", others)
    for (k in others) { split("", one); one[others[k]]; fit(one, fixed) }
    for (l = 1; l <= lines; ++l) {
        $0 = line[l]
        if ($1 == "machine:") print "machine: " machine
        else if ($1 in cost) { rest = line[l]; sub(/^[^#]*/, "", rest); printf "%s %.4g %s\n", $1, cost[$1] * 1e9, rest }
        else print line[l]
    }
    for (r = 1; r <= runs; ++r) printf "%s: said %.3f s, taken %.3f s, ratio %.2f\n", program[r], predicted[r], seconds[r], predicted[r] / seconds[r] > "/dev/stderr"
}