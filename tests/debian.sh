#!/usr/bin/env bash
# The README's two commands in a bare Debian 12: a folder made by debootstrap with git, make and nothing else of ours. The tree
# stands in a folder whose name has a space.
# Needs root and debootstrap. Usage: debian.sh [FOLDER]; a FOLDER that is named is kept for a second run. Packages come
# from where this machine's own apt takes bookworm main, or from DEBIAN_MIRROR.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)

# mirror_of FILE...: the first address of bookworm main in one-line sources (*.list) and in deb822 sources (*.sources).
mirror_of() {
    local file
    for file in "$@"; do
        [ -f "$file" ] || continue
        case $file in
        *.list) sed -n 's/#.*//; s/^ *deb \+\(\[[^]]*\] *\)\?\([^ ]*\) \+bookworm \(.* \)\?main\( .*\)\?$/\2/p' "$file";;
        *.sources)
            grep -v '^#' "$file" | awk '
                BEGIN { RS = ""; FS = "\n" }
                {
                    split("", field)
                    for (i = 1; i <= NF; i++)
                        if ($i ~ /^[ \t]/) field[key] = field[key] " " $i
                        else { key = tolower($i); sub(/:.*/, "", key); text = $i; sub(/^[^:]*:/, "", text); field[key] = text }
                    has_deb = (" " field["types"] " ") ~ / deb /
                    has_main = (" " field["suites"] " ") ~ / bookworm / && (" " field["components"] " ") ~ / main /
                    if (has_deb && has_main && tolower(field["enabled"]) !~ /no/) { split(field["uris"], uri, " "); print uri[1] }
                }';;
        esac
    done | head -n 1
}

mirror=${DEBIAN_MIRROR:-$(mirror_of /etc/apt/sources.list /etc/apt/sources.list.d/*)}
[ -n "$mirror" ] || {
    echo "debian.sh: the apt sources of this machine name no bookworm main: set DEBIAN_MIRROR to the address of a Debian mirror" >&2
    exit 1
}
root=${1:-$(mktemp -d)}
[ -x "$root/bin/bash" ] || debootstrap --variant=minbase --include=git,make,ca-certificates bookworm "$root" "$mirror"
# The bare system reaches packages as this one does.
cp /etc/resolv.conf "$root/etc/" 2>/dev/null || true
cp -r /etc/apt/. "$root/etc/apt/"
for cert in /usr/local/share/ca-certificates /etc/ssl/certs; do
    if [ -d "$cert" ]; then mkdir -p "$root$cert"; cp -rL "$cert/." "$root$cert/" 2>/dev/null || true; fi
done
mount -t proc proc "$root/proc" 2>/dev/null || true
mount -t devpts devpts "$root/dev/pts" 2>/dev/null || true
trap 'umount "$root/proc" "$root/dev/pts" 2>/dev/null || true; [ $# -gt 0 ] || rm -rf "$root"' EXIT

tree="my clouds/vdbcloud"
rm -rf "$root/$tree"
git clone -q "$top" "$root/$tree"
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} "$@"; }
picture=${PICTURE:-full}
inside make -C "$tree/pipelines" PICTURE="$picture"
inside make -C "$tree/tests"
# Twice is as good as once.
again=$(inside make -C "$tree/pipelines" PICTURE="$picture"; inside make -C "$tree/tests")
if printf '%s\n' "$again" | grep -vE '^make(\[[0-9]+\])?: (Entering|Leaving) directory' | grep -q .; then
    echo "the second run did something again:" >&2
    printf '%s\n' "$again" >&2
    exit 1
fi
echo "both commands pass on a bare Debian 12, and do nothing again the second time"
