# Profiles of the last period: gnuplot -c profiles.gp PROFILES.csv PLOT.svg
set terminal svg size 1000,640 font 'sans,13' background rgb 'white'
set output ARG2
set datafile separator ','
stats ARG1 skip 1 using 1 name 'last' nooutput
set datafile columnheaders
only(x, start) = start == last_max ? x : NaN
set multiplot layout 2,3
set yrange [0:*]; set ylabel 'z [m]'; set grid; set key top right
file = ARG1
set xlabel 'theta_l [K]'
plot file using (only(column('theta_l[K]'), column('time_start[s]'))):'z[m]' with lines lw 2 notitle
set xlabel 'q_t [g/kg]'
plot file using (only(1000 * column('q_t[kg/kg]'), column('time_start[s]'))):'z[m]' with lines lw 2 notitle
set xlabel 'wind [m/s]'
plot file using (only(column('u[m/s]'), column('time_start[s]'))):'z[m]' with lines lw 2 title 'u', \
     file using (only(column('v[m/s]'), column('time_start[s]'))):'z[m]' with lines lw 2 title 'v'
set xlabel 'cloud fraction [%]'
plot file using (only(100 * column('cloud_fraction'), column('time_start[s]'))):'z[m]' with lines lw 2 notitle
set xtics 0.02
set xlabel 'flux of q_t [g/kg m/s]'
plot file using (only(1000 * column('w_q_t[kg/kg m/s]'), column('time_start[s]'))):'z_face[m]' with lines lw 2 title 'resolved', \
     file using (only(1000 * column('subgrid_w_q_t[kg/kg m/s]'), column('time_start[s]'))):'z_face[m]' with lines lw 2 title 'sub-grid'
set xtics 0.05
set xlabel "variance of w [m^2/s^2]"
plot file using (only(column('w2[m^2/s^2]'), column('time_start[s]'))):'z_face[m]' with lines lw 2 notitle
unset multiplot
