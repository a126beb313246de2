# Plots of bench_precision's table: gnuplot -c precision.gp TABLE PICTURE.svg
set terminal svg size 1000,460 font "sans,13"
set output ARG2
set multiplot layout 1,2
set logscale xy
set format x "10^{%L}"
set key bottom left font ",10"
set yrange [0.002:1]
set grid
set ylabel "error of cloud water, 300 s"
methods = "fast default accurate forward-upwind huge-dt-10s huge-dt-10s-MacCormack"
set xlabel "CPU seconds"
plot for [i=0:5] ARG1 index i using 3:5 with linespoints lw 2 title word(methods, i + 1)
set xlabel "MB of fields"
unset key
plot for [i=0:5] ARG1 index i using 4:5 with linespoints lw 2 notitle
