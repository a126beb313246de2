# Kobayashi's problem 1: flux along the benchmark's three lines, published and ours. gnuplot -c kobayashi.gp TABLE.csv OUT.svg
table = ARG1
set terminal svg size 1200,840 font "sans,12" background "white"
set output ARG2
set datafile separator ","
set logscale y
set format y "10^{%L}"
set xrange [0:100]
set grid
set key bottom left font ",10"
# line CASE COLUMN SELECT RUNG: rows of one line of points at the finest voxels, by the coordinate that changes.
voxels = system(sprintf("awk -F, '/^kobayashi-1/ && (v == \"\" || $8 + 0 < v + 0) { v = $8 } END { print v }' '%s'", table))
line(problem, select, rung) = sprintf("< awk -F, '$1 == \"kobayashi-%s\" && $7 == \"%s\" && ($8 == \"%s\") { split($3, p, \" \"); if (%s) print p[axis] \",\" $4 \",\" $9 }' axis=%d '%s'", problem, rung, voxels, select, axis, table)
rungs(problem) = system(sprintf("awk -F, '$1 == \"kobayashi-%s\" && ($8 == \"%s\") && !seen[$7]++ { print $7 }' '%s'", problem, voxels, table))
select_A = "p[1] == 5 && p[3] == 5"
select_B = "p[1] == p[2] && p[2] == p[3]"
select_C = "p[2] == 55 && p[3] == 5"
set multiplot layout 2,3
do for [problem in "1i 1ii"] {
    do for [which in "A B C"] {
        select = value("select_".which)
        axis = which eq "C" ? 1 : 2
        set title sprintf("problem %s, case %s", "1".which, problem[2:])
        set xlabel (which eq "C" ? "x [cm]" : "y [cm]")
        set ylabel "flux [1/(cm^2 s)]"
        plot line(problem, select, strstrt(rungs(problem), "sweeps-128") ? "sweeps-128" : word(rungs(problem), 1)) using 1:2 with lines lc "black" lw 2 title "published", \
            for [rung in rungs(problem)] line(problem, select, rung) using 1:3 with points ps 0.7 title rung
    }
}
unset multiplot
