# Step cloud of I3RC by column: published and ours by rung. gnuplot -c i3rc.gp TABLE.csv OUT.svg
table = ARG1
set terminal svg size 1200,1000 font "sans,12" background "white"
set output ARG2
set datafile separator ","
set xrange [0.5:32.5]
set yrange [0:*]
set grid
set key top left font ",10"
set xlabel "column"
# Voxels in which most rungs were solved.
voxel = system(sprintf("awk -F, '$1 == \"step-4\" && $2 == \"R\" && !seen[$7, $8]++ { if (++n[$8] >= most) { most = n[$8]; v = $8 } } END { print v }' '%s'", table))
line(experiment, quantity, rung) = sprintf("< awk -F, '$1 == \"step-%s\" && $2 == \"%s\" && $3 != \"mean\" && $7 == \"%s\" && $8 == \"%s\" { print $3 \",\" $4 \",\" $9 }' '%s'", experiment, quantity, rung, voxel, table)
rungs(experiment, quantity) = system(sprintf("awk -F, '$1 == \"step-%s\" && $2 == \"%s\" && $3 != \"mean\" && $8 == \"%s\" && !seen[$7]++ { print $7 }' '%s'", experiment, quantity, voxel, table))
set multiplot layout 3,3
do for [panel in "1R 1T 1Iu 2R 2Id 2Iu 4R 4T 4Iu"] {
    experiment = panel[1:1]
    quantity = panel[2:]
    if (words(rungs(experiment, quantity)) > 0) {
        set title sprintf("step cloud, experiment %s: %s", experiment, quantity)
        plot line(experiment, quantity, word(rungs(experiment, quantity), 1)) using 1:2 with lines lc "black" lw 2 title "published", \
            for [rung in rungs(experiment, quantity)] line(experiment, quantity, rung) using 1:3 with points ps 0.6 title rung
    } else {
        set multiplot next
    }
}
unset multiplot
