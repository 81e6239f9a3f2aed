#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs what is missing of the Debian packages in jobs/packages.txt; needs no terminal.
#
#   jobs/install-packages.sh [GROUP...]    groups of packages.txt; default: build run figures report test
#
# Exit codes: 0 everything is there; 2 something is missing and this user may not install it.
set -euo pipefail
list=$(dirname "${BASH_SOURCE[0]}")/packages.txt

case ${1:-} in
    -h | --help)
        sed -n '3,/^set/{/^set/d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"
        exit 0
        ;;
esac
(($#)) || set -- build run figures report test
for group in "$@"; do
    if ! grep -q "^$group " "$list"; then
        echo "install-packages.sh: no group '$group' in $list" >&2
        exit 2
    fi
done

if ! command -v dpkg-query >/dev/null; then
    echo "Not a Debian system: packages are left alone; see docs/dependencies.md." >&2
    exit 0
fi

mapfile -t wanted < <(
    awk -v groups=" $* " '/^[a-z]/ && index(groups, " " $1 " ") { print $2 }' "$list"
)
# dpkg-query fails when it does not know a package, which is an answer too.
installed=$(dpkg-query --show --showformat='${Package} ${db:Status-Status}\n' \
    "${wanted[@]}" 2>/dev/null || true)
missing=()
for package in "${wanted[@]}"; do
    grep -qx "$package installed" <<<"$installed" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
    exit 0
fi

administrator=()
if ((EUID != 0)); then
    if ! { command -v sudo && sudo -n true; } &>/dev/null; then
        {
            echo "Missing packages: ${missing[*]}"
            echo "Ask an administrator of this machine to run:"
            echo "    apt-get update && apt-get install --no-install-recommends ${missing[*]}"
        } >&2
        exit 2
    fi
    administrator=(sudo -n)
fi
apt_get() {
    "${administrator[@]}" env DEBIAN_FRONTEND=noninteractive apt-get --quiet --yes \
        -o DPkg::Lock::Timeout=600 -o Acquire::Retries=3 -o Dpkg::Use-Pty=0 "$@" </dev/null
}
echo "Installing ${missing[*]}"
apt_get update
apt_get install --no-install-recommends "${missing[@]}"
