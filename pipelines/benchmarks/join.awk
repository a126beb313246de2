# Joins published values and results to one table: awk -f join.awk PUBLISHED.csv... RESULTS.csv... > table.csv. The column
# names of a file, its first line that is no comment, tell which of both it is. A result without a published value has
# empty fields; a published value without a result is left out.
BEGIN {
    FS = OFS = ","
    print "case", "quantity", "place", "published", "spread", "source", "rung", "voxel", "ours", "noise", "error_percent", "seconds"
}
FNR == 1 { named = 0 }
/^#/ { next }
!named { named = 1; theirs = $4 == "published"; next }
theirs { value[$1, $2, $3] = $4; spread[$1, $2, $3] = $5; source[$1, $2, $3] = $6; next }
{
    known = ($1, $2, $3) in value
    published = known ? value[$1, $2, $3] : ""
    error = known ? sprintf("%.2f", 100 * ($6 / published - 1)) : ""
    print $1, $2, $3, published, spread[$1, $2, $3], source[$1, $2, $3], $4, $5, $6, $7, error, $8
}
