#!/usr/bin/env bash
# The README's two commands in a bare Debian 12: a folder made by debootstrap with git, make and nothing else of ours.
# Needs root and debootstrap. Usage: debian.sh [FOLDER]; the folder is kept for a second run if it is named.
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
root=${1:-$(mktemp -d)}
mirror=${DEBIAN_MIRROR:-$(sed -n 's/^deb [^h]*\(http[^ ]*\).* bookworm main.*/\1/p; s/^URIs: //p' /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | head -n 1 || true)}
mirror=${mirror:-http://deb.debian.org/debian}

[ -x "$root/bin/bash" ] || debootstrap --variant=minbase --include=git,make,ca-certificates bookworm "$root" "$mirror"
# The bare system reaches packages as this one does.
cp /etc/resolv.conf "$root/etc/" 2>/dev/null || true
cp -r /etc/apt/. "$root/etc/apt/"
for cert in /usr/local/share/ca-certificates /etc/ssl/certs; do
    [ -d "$cert" ] && mkdir -p "$root$cert" && cp -rL "$cert/." "$root$cert/" 2>/dev/null || true
done
mount -t proc proc "$root/proc" 2>/dev/null || true
mount -t devpts devpts "$root/dev/pts" 2>/dev/null || true
trap 'umount "$root/proc" "$root/dev/pts" 2>/dev/null || true; [ $# -gt 0 ] || rm -rf "$root"' EXIT

rm -rf "$root/vdbcloud"
git clone -q "$top" "$root/vdbcloud"
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} "$@"; }
picture=${PICTURE:-full}
inside make -C vdbcloud/pipelines PICTURE="$picture"
inside make -C vdbcloud/tests
# Twice is as good as once.
again=$(inside make -C vdbcloud/pipelines PICTURE="$picture"; inside make -C vdbcloud/tests)
if printf '%s\n' "$again" | grep -vE '^make(\[[0-9]+\])?: (Entering|Leaving) directory' | grep -q .; then
    echo "the second run did something again:" >&2
    printf '%s\n' "$again" >&2
    exit 1
fi
echo "both commands pass on a bare Debian 12, and do nothing again the second time"
