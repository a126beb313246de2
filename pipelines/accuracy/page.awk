# The page of the studies: awk -v form=html|md -v machine=TEXT -v asked=TEXT -v folder=OUT -f page.awk studies.txt orders.csv table.csv.
# html has plots (STUDY.svg), all points and pictures beside the page; md is docs/accuracy.md.
BEGIN { FS = ","; targets = split("10 3 1 0.3", target, " ") }
FNR == 1 { ++file }
file == 1 && /^study / {
    name = $0; sub(/^study /, "", name); sub(/:.*/, "", name)
    studies[++study_count] = name; title[name] = $0; sub(/^[^:]*: /, "", title[name])
}
file == 1 && /^text / { text[name] = substr($0, 6) }
file == 1 && /^choose / { choose[name] = substr($0, 8) }
file == 1 && /^costs / { costs[name] = substr($0, 7); gsub(/ /, ", ", costs[name]) }
file == 1 && /^pictures/ { drawn[name] = 1 }
file == 2 { orders[$2] = orders[$2] (orders[$2] == "" ? "" : "; ") $4 " (" $3 ")" ": " $5 ", expected " $6 " to " $7; next }
file < 3 || $1 == "study" { next }
{
    s = $1
    if (!((s, $2) in known)) { known[s, $2] = 1; cases[s, ++case_count[s]] = $2 }
    row = ++rows[s]; at[s, row] = $0
    for (t = 1; t <= targets; ++t)
        if ($8 <= target[t] && (!((s, $2, t) in best) || $10 < best[s, $2, t])) { best[s, $2, t] = $10; method[s, $2, t] = said($3, $4) ": " seconds($10) " s" }
    if (!((s, $2) in least) || $8 < least[s, $2]) least[s, $2] = $8
}
END {
    head()
    for (k = 1; k <= study_count; ++k) {
        s = studies[k]
        if (!rows[s]) continue
        section(title[s])
        paragraph(text[s] " Seconds are of " costs[s] ".")
        if (form == "html") print "<img src=\"" s ".svg\" alt=\"" title[s] ": error against processor seconds\">"
        paragraph(strong("Choose:") choose[s])
        begin_table("case|at most 10 %|3 %|1 %|0.3 %")
        for (c = 1; c <= case_count[s]; ++c) {
            line = cases[s, c]
            for (t = 1; t <= targets; ++t) line = line "|" ((s, cases[s, c], t) in best ? method[s, cases[s, c], t] : "none; the best is known to " rounded(least[s, cases[s, c]]) " %")
            table_row(line)
        }
        end_table()
        if (orders[s] != "") paragraph("Orders, the slopes of the error: " orders[s] ".")
        if (form == "html") points(s)
        if (form == "html" && drawn[s]) pictures(s)
    }
    if (form == "html") print "</body></html>"
}
function said(m, setting) { return index(setting, m) == 1 ? setting : m ", " setting }
function seconds(x) { return sprintf(x < 0.995 ? "%.2f" : x < 9.95 ? "%.1f" : "%.0f", x) }
function rounded(x) { return sprintf("%.2g", x < 0.001 ? 0.001 : x) + 0 }
function interval(l, h) { return l == h ? "" : " (" rounded_or_0(l) " to " rounded(h) ")" }
function rounded_or_0(x) { return x == 0 ? 0 : rounded(x) }
function points(s,    row, part) {
    print "<details><summary>All points</summary>"
    begin_table("case|method|setting|error [%], 95 %|mean [%]|seconds|MB")
    for (row = 1; row <= rows[s]; ++row) {
        split(at[s, row], part, ",")
        table_row(part[2] "|" part[3] "|" part[4] "|" rounded_or_0(part[6]) interval(part[7], part[8]) "|" sprintf("%+.2g", part[9]) "|" seconds(part[10]) "|" part[11])
    }
    end_table()
    print "</details>"
}
# A row of pictures for each case, and beneath it the errors of their blocks.
function pictures(s,    c, row, part, shown, limit, file, line) {
    for (c = 1; c <= case_count[s]; ++c) {
        print "<h3>" cases[s, c] "</h3><div class=\"row\">"
        for (row = 1; row <= rows[s]; ++row) {
            split(at[s, row], part, ",")
            if (part[2] != cases[s, c]) continue
            shown = s "-" part[2] "-" part[3] "-" part[4]
            gsub(/[^A-Za-z0-9.]+/, "-", shown)
            shown = "runs/pictures/" shown
            limit = "?"; file = folder "/" shown ".limit"
            if ((getline line < file) > 0) limit = line
            close(file)
            print "<figure><img src=\"" shown ".png\" alt=\"" part[4] "\"><img src=\"" shown ".errors.png\" alt=\"errors of " part[4] \
                "\"><figcaption>" said(part[3], part[4]) ": " rounded_or_0(part[6]) interval(part[7], part[8]) " %, " seconds(part[10]) " s. Full red: " limit " % too bright</figcaption></figure>"
        }
        print "</div>"
    }
}
function head() {
    if (form == "html") {
        print "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>What accuracy costs</title>"
        print "<style>body{font:16px/1.45 sans-serif;max-width:75rem;margin:2rem auto;padding:0 1rem;color:#222}img{max-width:100%}"
        print "table{border-collapse:collapse;margin:1rem 0}td,th{border-bottom:1px solid #ccc;padding:.25rem .75rem;text-align:left;vertical-align:top}"
        print ".row{display:flex;flex-wrap:wrap;gap:.75rem}figure{margin:0;width:17rem}figure img{width:100%;display:block;image-rendering:pixelated}"
        print "figcaption{font-size:.85rem}summary{cursor:pointer}</style></head><body>\n<h1>What accuracy costs</h1>"
    } else print "# What accuracy costs\n"
    paragraph("You want a picture of a given error in the least time, or want to know what the next digit costs. Each study below changes one part of the chain and measures error against processor seconds" (form == "html" ? "" : " (`docs/certificate.md` measures the error of a picture of your own)") ". " \
        "Errors are root mean squares over blocks of 8 x 8 pixels, relative to the mean of the true picture. The tables name the cheapest setting whose error, with its 95 % interval, is at most the one asked for. " \
        "Seconds are processor time on this machine: " machine ". Start-up of a program takes a twentieth of a second.")
    if (form == "md") {
        print "    " asked "\n"
        print "makes everything from nothing, `index.html` with plots and pictures in the output folder of that pipeline, `table.csv` with every point, and this page; a run that is stopped goes on. `SIZE=full` takes finer grids, `PICTURE=small` a minute. `pipelines/accuracy/studies.txt` defines the studies. Errors that do not fall with the order that theory gives, and a point that is dearer than the one before and errs more, end the run with status 1.\n"
    } else paragraph("Made by <code>" asked "</code>.")
}
function section(x) { print form == "html" ? "<h2>" x "</h2>" : "## " x "\n" }
function paragraph(x) { if (form == "html") { gsub(/ < /, " \\&lt; ", x); print "<p>" x "</p>" } else print x "\n" }
function strong(x) { return form == "html" ? "<strong>" x "</strong> " : "**" x "** " }
function begin_table(names,    n, k, name, line) {
    n = split(names, name, "|")
    if (form == "html") {
        line = "<table><tr>"; for (k = 1; k <= n; ++k) line = line "<th>" name[k] "</th>"
        print line "</tr>"
        return
    }
    line = "|"; for (k = 1; k <= n; ++k) line = line " " name[k] " |"
    print line
    line = "|"; for (k = 1; k <= n; ++k) line = line "---|"
    print line
}
function table_row(values,    n, k, value, line) {
    n = split(values, value, "|")
    line = form == "html" ? "<tr>" : "|"
    for (k = 1; k <= n; ++k) line = line (form == "html" ? "<td>" value[k] "</td>" : " " value[k] " |")
    print line (form == "html" ? "</tr>" : "")
}
function end_table() { print form == "html" ? "</table>" : "" }
