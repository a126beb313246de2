# One scene for render and for Blender's Cycles: fractalgen's cloud of seed 7, 20 mean free paths in a world unit at density 1,
# under a sun of irradiance 1, seen by parallel rays in a picture `width` world units wide. Sourced by compare.sh and by
# pipelines/versus-cycles/versus.sh.
scene=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
extinction=20 sun=0.3,1,0.2 camera=6,3,8 target=0,0.55,0 width=${width:-2.4}
view=(--projection orthographic --camera $camera --look-at $target --ortho-width "$width")

# cycles FILE VOXELS ALBEDO G PIXELS SAMPLES SEED OUT.exr [REPORT.json]: a picture by Cycles; prints processor seconds of all threads, without
# Blender's start. VOXELS is the cloud's --size: its voxel is 2 / VOXELS world units.
cycles() {
    local said=$8.said
    blender -b --factory-startup --python-exit-code 1 -P "$scene/cycles.py" -- "$1" $extinction "$3" "$4" $sun $camera $target "$width" \
        "$5" "$6" "$7" "$(awk -v n="$2" 'BEGIN { print 2 / n }')" "$8" ${9:+"$9"} > "$said" 2>&1 || { cat "$said" >&2; return 1; }
    sed -n 's/^cpu //p' "$said"
}

# average FILE: mean of a picture's first channel.
average() { oiiotool "$1" --ch 0 --printstats | sed -n 's/.*Stats Avg: *\([0-9.e+-]*\).*/\1/p'; }
