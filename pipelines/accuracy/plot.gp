# Error against processor seconds of one study, a plot for each of its cases. gnuplot -c plot.gp TABLE.csv STUDY OUT.svg
table = ARG1
study = ARG2
list(condition, column) = system(sprintf("awk -F, '$1 == \"%s\" %s && !seen[$%d]++ { gsub(/ /, \"_\", $%d); print $%d }' '%s'", study, condition, column, column, column, table))
cases = list("", 2)
n = words(cases)
columns = n > 1 ? 2 : 1
rows = (n + columns - 1) / columns
set terminal svg size 640 * columns, 400 * rows font "sans,13" background "white"
set output ARG3
set datafile separator ","
set logscale xy
set format x "%g"
set format y "%g"
set grid
set key outside right top vertical font ",11" width -1
set xlabel "processor seconds"
set ylabel "error [%]"
# Errors of 0 have no place on a logarithm: an interval that reaches 0 ends at a thirtieth of its upper end, and an error that is
# 0 in every bit stands at a hundred-thousandth of a percent.
above(e, high) = e > high / 30 ? e : high > 3e-4 ? high / 30 : 1e-5
points(c, m) = sprintf("< awk -F, '{ c = $2; m = $3; gsub(/ /, \"_\", c); gsub(/ /, \"_\", m) } $1 == \"%s\" && c == \"%s\" && m == \"%s\"' '%s'", study, c, m, table)
readable(name) = system("echo '" . name . "' | tr _ ' '")
set multiplot layout rows, columns
do for [k = 1:n] {
    c = word(cases, k)
    methods = system(sprintf("awk -F, '{ c = $2; m = $3; gsub(/ /, \"_\", c); gsub(/ /, \"_\", m) } $1 == \"%s\" && c == \"%s\" && !seen[m]++ { print m }' '%s'", study, c, table))
    set title readable(c)
    plot for [i = 1:words(methods)] points(c, word(methods, i)) using 10:(above($6, $8)):(above($7, $8)):(above($8, $8)) \
             with yerrorlines lw 2 pt i + 3 ps 0.6 lc i title readable(word(methods, i))
}
unset multiplot
