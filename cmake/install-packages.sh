#!/bin/sh
# Installs what packages.txt lists and this machine lacks. Silent, and asks for no rights, when nothing is missing.
# Usage: install-packages.sh PACKAGES.TXT
set -eu
if ! command -v dpkg-query >/dev/null; then
    echo "install-packages.sh: no dpkg here: install the libraries of $1 by this system's own means" >&2
    exit 0
fi
wanted=$(sed 's/#.*//' "$1" | tr -s ' \t\n' ' ')
missing=
for package in $wanted; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" = 0 ]; then root=
elif command -v sudo >/dev/null; then root=sudo
else
    echo "install-packages.sh: these Debian packages are missing, and there is neither root nor sudo:$missing" >&2
    exit 1
fi
echo "installing:$missing"
export DEBIAN_FRONTEND=noninteractive
$root apt-get update -qq
# shellcheck disable=SC2086  # a list of words
$root apt-get install -y -qq --no-install-recommends $missing >/dev/null
