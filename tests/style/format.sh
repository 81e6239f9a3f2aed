#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Sources are formatted by clang-format 14. Exit code 77 (skipped) without that version, because
# others break lines differently.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

for formatter in clang-format-14 clang-format ""; do
    if [[ $("$formatter" --version 2>/dev/null) == *"version 14."* ]]; then
        break
    fi
done
if [[ -z $formatter ]]; then
    echo "clang-format 14 is not installed"
    exit 77
fi

if ! complaints=$(find src tests -name '*.[ch]pp' -print0 |
    xargs -0 "$formatter" --style=file --dry-run -Werror 2>&1); then
    places=$(sed -n 's/^\([^ :]*\):[0-9]*:[0-9]*: error: .*/\1/p' <<<"$complaints" | sort --unique)
    printf '%s\n' "$formatter -i is due for:" "${places:-$complaints}"
    exit 1
fi
