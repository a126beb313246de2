# Writes the page from the table: awk -f page.awk table.csv bars.csv page.md > benchmarks.md. Lines of page.md that begin with @
# are replaced:
#
#   @summary PREFIX QUANTITY...   a row for each case that begins with PREFIX, rung and voxel; a column for each quantity: the
#                     error of a mean; of several places rms and, in brackets, the largest error
#   @values PREFIX    as @summary, with our means in place of their errors
#   @points CASE      published and ours by rung, in the finest voxels, for each place
#   @bars             a row for each bar: its limit, what was reached
#
# In other lines @machine is replaced by the variable of that name.
#
# Errors are in per cent of the published value.
BEGIN { FS = "," }
FNR == 1 { ++file; named = 0 }
file < 3 && /^#/ { next }
file < 3 && !named { named = 1; next }  # names of columns
file == 1 {
    group = $1 "," $7 "," $8
    if (!(group in seconds)) { groups[++group_count] = group; seconds[group] = $12 }
    if (!(($1, $7) in finest) || $8 + 0 < finest[$1, $7] + 0) finest[$1, $7] = $8
    if (!(($1, $7) in known_rung)) { known_rung[$1, $7] = 1; rungs[$1, ++rung_count[$1]] = $7 }
    if (!(($1, $3) in known_place)) { known_place[$1, $3] = 1; places[$1, ++place_count[$1]] = $3 }
    ours[$1, $2, $3, $7, $8] = $9
    if ($4 == "") next
    published[$1, $2, $3] = $4
    error[$1, $2, $3, $7, $8] = $11
    # Means and places of one quantity are two statistics.
    key = group "," $2 ($3 == "mean" ? "" : " by place")
    quantity = $2 ($3 == "mean" ? "" : " by place")
    ++n[key]; squares[key] += $11 * $11
    if (n[key] == 1 || magnitude($11) > magnitude(worst[key])) worst[key] = $11
    known_quantity[family($1), quantity] = 1
    next
}
file == 2 { bars[++bar_count] = $0; next }
/^@summary / { sub(/^@summary /, ""); summary($0); next }
/^@values / { values(substr($0, 9)); next }
/^@points / { points(substr($0, 9)); next }
/^@bars/ { print_bars(); next }
{ gsub("@machine", machine); print }

function magnitude(x) { return x < 0 ? -x : x }
function family(case_) { sub(/-.*/, "", case_); return case_ }
function signed(x) { return sprintf(magnitude(x) < 1000 ? "%+.1f" : "%+.0f", magnitude(x) < 0.05 ? 0 : x) }
function statistic(key) {
    if (!(key in n)) return ""
    return n[key] == 1 ? signed(worst[key]) : sprintf(squares[key] / n[key] < 1e6 ? "%.1f (%s)" : "%.0f (%s)", sqrt(squares[key] / n[key]), signed(worst[key]))
}
function measured(prefix,    k) {
    for (k = 1; k <= group_count; ++k) if (index(groups[k], prefix) == 1) return 1
    print "Not part of the last run."
    return 0
}
function summary(text,    count, wanted, prefix, column, columns, q, k, line, part, name) {
    count = split(text, wanted, " ")
    prefix = wanted[1]
    if (!measured(prefix)) return
    for (q = 2; q <= count; ++q)
        for (k = 0; k < 2; ++k) {
            name = wanted[q] (k ? " by place" : "")
            if ((family(prefix), name) in known_quantity) column[++columns] = name
        }
    line = "| case | rung | voxel | seconds |"; for (q = 1; q <= columns; ++q) line = line " " column[q] " |"
    print line
    line = "|---|---|--:|--:|"; for (q = 1; q <= columns; ++q) line = line "--:|"
    print line
    for (k = 1; k <= group_count; ++k) {
        if (index(groups[k], prefix) != 1) continue
        split(groups[k], part, ",")
        line = "| " part[1] " | " part[2] " | " sprintf("%.4g", part[3]) " | " seconds[groups[k]] " |"
        for (q = 1; q <= columns; ++q) line = line " " statistic(groups[k] "," column[q]) " |"
        print line
    }
}
function values(prefix,    k, part, q, line, head, rule, name) {
    if (!measured(prefix)) return
    head = "| case | rung | voxel | seconds |"; rule = "|---|---|--:|--:|"; name[1] = "R"; name[2] = "T"; name[3] = "A"
    for (q = 1; q <= 3; ++q) { head = head " " name[q] " |"; rule = rule "--:|" }
    print head; print rule
    for (k = 1; k <= group_count; ++k) {
        if (index(groups[k], prefix) != 1) continue
        split(groups[k], part, ",")
        line = "| " part[1] " | " part[2] " | " sprintf("%.4g", part[3]) " | " seconds[groups[k]] " |"
        for (q = 1; q <= 3; ++q)
            line = line " " ((part[1], name[q], "mean", part[2], part[3]) in ours ? sprintf("%.4f", ours[part[1], name[q], "mean", part[2], part[3]]) : "") " |"
        print line
    }
}
# Ours in the finest voxels of that rung.
function value_at(case_, quantity, place, rung,    v) {
    v = finest[case_, rung]
    return (case_, quantity, place, rung, v) in ours ? sprintf("%.4g", ours[case_, quantity, place, rung, v]) : ""
}
function points(case_,    k, r, line, p, q) {
    if (!measured(case_)) return
    q = "flux"
    line = "| point | published |"; for (r = 1; r <= rung_count[case_]; ++r) line = line " " rungs[case_, r] " |"
    print line
    line = "|---|--:|"; for (r = 1; r <= rung_count[case_]; ++r) line = line "--:|"
    print line
    for (k = 1; k <= place_count[case_]; ++k) {
        p = places[case_, k]
        line = "| " p " | " published[case_, q, p] " |"
        for (r = 1; r <= rung_count[case_]; ++r)
            line = line " " value_at(case_, q, p, rungs[case_, r]) " |"
        print line
    }
}
# A bar: name,pattern of cases,quantity,rung,statistic (worst or rms),limit in per cent,seconds or nothing.
function print_bars(    b, part, k, g, key, reached, slow, found, value) {
    print "| bar | limit | reached | |"
    print "|---|--:|--:|---|"
    for (b = 1; b <= bar_count; ++b) {
        split(bars[b], part, ",")
        reached = slow = found = 0
        for (k = 1; k <= group_count; ++k) {
            split(groups[k], g, ",")
            key = groups[k] "," part[3]
            if (g[1] !~ ("^(" part[2] ")$") || g[2] != part[4] || g[3] != finest[g[1], g[2]] || !(key in n)) continue
            found = 1
            value = part[5] == "rms" ? sqrt(squares[key] / n[key]) : magnitude(worst[key])
            if (value > reached) reached = value
            if (seconds[groups[k]] + 0 > slow) slow = seconds[groups[k]] + 0
        }
        print "| " part[1] " | " part[6] " %" (part[7] == "" ? "" : ", " part[7] " s") " | " \
            (found ? sprintf("%.1f %%", reached) (part[7] == "" ? "" : sprintf(", %.1f s", slow)) : "") " | " \
            (!found ? "not measured" : reached > part[6] + 0 || (part[7] != "" && slow > part[7] + 0) ? "missed" : "met") " |"
    }
}
