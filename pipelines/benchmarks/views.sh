# The unit cube from three sides, as data/references/puffs.txt and blobs.txt have it. To be sourced by bash.

# cube_views: "NAME CAMERA TURN" of each view; cube_camera: the options that all views have.
cube_views() { printf '%s\n' 'above 0.5,9,0.5 z-x' 'side 0.5,0.5,9 xy' 'below 0.5,-9,0.5 zx'; }
cube_camera=(--projection orthographic --ortho-width 1 --look-at 0.5,0.5,0.5)

# A function of awk, to be put before a program: "a b" of column i and row j from the top, of 0 .. last. TURN names the axes of a
# and b, - before one that falls to the right: x and z seen from above and below, x and y from the side.
cube_place='
function cube_place(turn, i, j, last) {
    if (turn == "xy") return i " " (last - j)
    if (turn == "z-x") return (last - j) " " i
    return (last - j) " " (last - i)
}'
