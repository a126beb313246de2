# Ours beside published ranges: awk -v case=bomex -v averaged=SECONDS -f table.awk published.csv SERIES.csv PROFILES.csv > table.csv.
# Of the series and of the profiles the last `averaged` seconds count: means, and the standard deviation of samples.
BEGIN { FS = OFS = "," }
FNR == 1 { file++; named = 0 }
/^#/ { next }
!named { named = 1; for (i = 1; i <= NF; i++) { name = $i; sub(/\[.*/, "", name); column[file, name] = i }; next }
function of(name) { return $column[file, name] }
file == 1 && $1 == case { order[++rows] = $2; low[$2] = $3; high[$2] = $4; unit[$2] = $5; source[$2] = $6 }
file == 2 { time[++samples] = of("time"); line[samples] = $0 }
file == 3 && of("time_start") >= end - averaged - 1 {
    z = of("z"); n[z]++
    fraction[z] += of("cloud_fraction"); w2[of("z_face")] += of("w2")
}
file == 2 { end = of("time") }
# Adds what the last samples say of a column of the series.
function series(name, as,    k, i, v, m, sum, squares) {
    for (k = 1; k <= samples; k++) if (time[k] > end - averaged) {
        split(line[k], v, FS); sum += v[column[2, name]]; squares += v[column[2, name]] ^ 2; m++
    }
    ours[as] = sum / m; deviation[as] = sqrt(squares / m > ours[as] ^ 2 ? squares / m - ours[as] ^ 2 : 0)
}
END {
    split("cloud_cover lwp rwp tke_path", plain, " ")
    for (i in plain) series(plain[i], plain[i])
    # Cloud base and top: where the mean cloud fraction passes a tenth of a percent.
    most = top = 0; base = -1; below = within = 0
    for (z in n) {
        f = fraction[z] / n[z]
        if (f > most) most = f
        if (f > 1e-3 && z + 0 > top) top = z + 0
        if (f > 1e-3 && (base < 0 || z + 0 < base)) base = z + 0
    }
    for (z in w2) {
        variance = w2[z] / periods_of(z)
        if ((base < 0 || z + 0 < base) && variance > below) below = variance
        if (base >= 0 && z + 0 >= base && variance > within) within = variance
    }
    ours["cloud_base"] = base; ours["cloud_top"] = top; ours["cloud_fraction_max"] = most
    ours["w2_subcloud"] = below; ours["w2_cloud"] = within
    before = now = 0
    for (k = 1; k <= samples; k++) {
        split(line[k], cells, FS)
        if (time[k] <= end - averaged) before = cells[column[2, "rain_fallen"]]
        now = cells[column[2, "rain_fallen"]]
    }
    ours["rain"] = (now - before) * 86400 / averaged  # kg/m^2 are mm
    print "case", "quantity", "published_low", "published_high", "ours", "deviation_of_samples", "unit", "within", "source"
    for (r = 1; r <= rows; r++) {
        q = order[r]
        spread = (q in deviation) ? sprintf("%.2g", deviation[q]) : ""
        verdict = (ours[q] >= low[q] && ours[q] <= high[q]) ? "yes" : "no"
        print case, q, low[q], high[q], sprintf("%.4g", ours[q]), spread, unit[q], verdict, source[q]
    }
}
# Periods that the profiles of a height are of: faces have as many as centres.
function periods_of(face,    any) { for (any in n) return n[any] }
