#!/usr/bin/env bash
# Writes the page of the gallery to standard output: page.sh OUT PICTURE...
set -euo pipefail
out=$1
shift
how=
case $1 in PICTURE=*) how="$1 " && shift ;; esac

# number REPORT MEMBER NAME: of the certificate, in per cent.
number() {
    awk -v member="\"$2\"" -v name="\"$3\"" '
        index($1, "\"certificate\"") { inside = 1 }
        inside && index($1, member) { here = 1 }
        here && index($1, name) { sub(/,$/, "", $2); printf "%.2g", 100 * $2; exit }' "$1"
}

# effects REPORT: those in play, as render decided (docs/effects.md).
effects() {
    awk '/^  "effects": \{/ { inside = 1; next }
        inside && /^  \}/ { exit }
        inside && /^    "[a-z_-]*": \{/ { name = $1; gsub(/[":]/, "", name) }
        inside && $1 == "\"on\":" && $2 ~ /^true/ { printf "%s%s", between, name; between = ", " }' "$1"
}

# What Kajiya and Von Herzen 1984 say of their pictures of this kind.
paper() {
    case $1 in
    fractal-cumulus | sunset | mirror-sphere | ground-shadow) echo "fractal clouds at 512 x 512: 1 to 6 hours of a processor" ;;
    cloud-and-mountain) echo "cloud and mountain at 256 x 256: 1 to 6 hours of a processor" ;;
    cumulus-growth) echo "simulated cloud at 512 x 512: 1 to 6 hours of a processor" ;;
    *) echo "no picture of this kind" ;;
    esac
}

cat << 'EOF'
<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<title>vdbcloud: gallery</title>
<style>
body { font: 16px/1.5 sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem }
figure { margin: 0 0 3rem }
img { width: 100%; height: auto; display: block }
table { border-collapse: collapse; margin-top: .5rem }
td { padding: .1rem 1rem .1rem 0; vertical-align: top }
</style>
<body>
<h1>Gallery</h1>
<p>Each picture with its command, the seconds of its stages on this machine, and its error: the root mean square over blocks of 32 x 32
pixels, relative to the mean of the picture, measured against light paths, with an interval of 95 %.</p>
EOF
for p in "$@"; do
    [ -s "$out/$p/$p.png" ] || { echo "page.sh: $out/$p/$p.png is missing" >&2; exit 1; }
    error=$(number "$out/$p/report.json" rms_32x32 value)
    low=$(number "$out/$p/report.json" rms_32x32 low) high=$(number "$out/$p/report.json" rms_32x32 high)
    [ -n "$error" ] || { echo "page.sh: $out/$p/report.json has no certificate" >&2; exit 1; }
    stages=
    for s in density.vdb light.vdb scatter.vdb png; do
        [ -e "$out/$p/$p.$s.seconds" ] && stages="$stages${stages:+, }${s%.vdb} $(< "$out/$p/$p.$s.seconds") s"
    done
    cat << EOF
<figure id="$p">
<a href="$p/$p.png"><img src="$p/$p.png" alt="$p"></a>
<figcaption><h2>$p</h2>
<table>
<tr><td>command<td><code>make -C pipelines ${how}$p</code>
<tr><td>stages<td>$stages (png: picture and certificate)
<tr><td>effects in play<td>$(effects "$out/$p/report.json")
<tr><td>error<td>$error % ($low to $high)
<tr><td>the paper, 1984<td>$(paper "$p")
</table></figcaption>
</figure>
EOF
done
echo "</body></html>"
