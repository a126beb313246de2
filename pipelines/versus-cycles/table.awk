# Tables of versus.csv as Markdown: means of the pictures, then errors and processor seconds.
BEGIN {
    FS = ","
    marches = "marches through a volume in steps, with a bias of the step. Blender 5.0 and newer sample volumes without bias."
    unbiased = "samples volumes by null scattering, without bias."
}
NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
function get(name) { return $column[name] }
function percent(x) { return sprintf("%.2g", 100 * x) }
function seconds(x) { return x == "never" ? x : sprintf("%.3g", x) }
# by_noise NAME: a figure that the noise may hide.
function by_noise(name) { return (get(name "_low") > 0) ? percent(get(name)) : "below " percent(get(name "_high")) }
function difference(a, b, half) { return sprintf("%+.1f +- %.1f %%", 100 * (a / b - 1), 100 * half) }
NR == 2 {
    print "Cycles of Blender " get("blender") " " ((get("blender") + 0 >= 5) ? unbiased : marches)
    printf "Cloud of %d^3 voxels, %dx%d pixels, albedo %s. ", get("voxels"), get("pixels"), get("pixels"), get("albedo")
    print "Seconds are processor time.\n"
    print "| g | mean radiance of our chain | of Cycles | of light paths | chain - Cycles | chain - paths | Cycles - paths |"
    print "|--:|--:|--:|--:|--:|--:|--:|"
}
get("block") == 8 {
    chain = get("chain_mean"); cycles = get("cycles_mean"); paths = get("paths_mean")
    noise = get("cycles_mean_half_width"); paths_noise = get("paths_mean_half_width")
    printf "| %s | %.5f | %.5f | %.5f | %s | %s | %s |\n", get("g"), chain, cycles, paths, difference(chain, cycles, noise),
        difference(chain, paths, paths_noise), difference(cycles, paths, sqrt(noise ^ 2 + paths_noise ^ 2))
    pictures = pictures sprintf("\ng = %s: our chain, %.2g s; Cycles with %d sample%s, %.2g s; Cycles with %d samples, %.3g s",
        get("g"), get("chain_seconds"), get("few_samples"), (get("few_samples") == 1) ? "" : "s", get("few_seconds"),
        get("samples"), get("cycles_seconds"))
}
{
    low = get("seconds_at_equal_error_low"); high = get("seconds_at_equal_error_high")
    error = by_noise("chain_error") " %"
    if (get("chain_error_low") > 0) {
        error = percent(get("chain_error")) " (" percent(get("chain_error_low")) " to " percent(get("chain_error_high")) ") %"
        least = get("seconds_at_equal_error")
        equal = seconds(least) " (" seconds(low) " to " seconds(high) ")"
    } else {  # an upper bound of the error: at least so many seconds
        least = low
        equal = (low == "never") ? low : "above " seconds(low)
    }
    if (get("reliable") == "false") error = error ", unreliable"
    rows = rows sprintf("| %s | %dx%d | %.3g | %s | %s %% | %d | %.3g | ", get("g"), get("block"), get("block"),
        get("chain_seconds"), error, by_noise("difference"), get("samples"), get("cycles_seconds"))
    rows = rows sprintf("%s %% | %s %% | %s | %s |\n", percent(get("cycles_noise")), by_noise("cycles_bias"), equal,
        (least == "never") ? "" : sprintf("%.3g", least / get("chain_seconds")))
}
END {
    printf "\n| g | blocks | CPU s of chain | its error | difference | samples of Cycles | CPU s | noise | bias | "
    print "CPU s of Cycles at the chain's error | ratio |"
    print "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    printf "%s", rows
    print "\nversus.png, from left to right:" pictures
}
