# Radiance of slabs by angle: error of each rung. gnuplot -c slabs.gp TABLE.csv OUT.svg
table = ARG1
set terminal svg size 1200,420 font "sans,12" background "white"
set output ARG2
set datafile separator ","
set xrange [0:180]
set xtics 30
set grid
set key top left font ",10"
set xlabel "angle from the sun's way [degrees]"
set ylabel "error of radiance [%]"
line(tau, rung) = sprintf("< awk -F, '$1 == \"slab-%s\" && $2 == \"I\" && $7 == \"%s\" { print $3 \",\" $11 }' '%s'", tau, rung, table)
rungs(tau) = system(sprintf("awk -F, '$1 == \"slab-%s\" && $2 == \"I\" && !seen[$7]++ { print $7 }' '%s'", tau, table))
set multiplot layout 1,3
do for [tau in "1 4 15"] {
    if (words(rungs(tau)) > 0) {
        set title sprintf("slab of optical depth %s", tau)
        plot for [rung in rungs(tau)] line(tau, rung) using 1:2 with linespoints ps 0.6 title rung
    } else {
        set multiplot next
    }
}
unset multiplot
