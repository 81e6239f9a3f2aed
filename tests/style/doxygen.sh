#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Doxygen makes the API documentation without a warning. Exit code 77 if doxygen is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v doxygen > /dev/null || { echo "there is no doxygen"; exit 77; }
output=$(mktemp -d)
trap 'rm -rf "$output"' EXIT
settings="$(cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $output")"
warnings=$(doxygen - <<< "$settings" 2>&1)
pages=$(find "$output/html" -name "*.html" | wc -l)
if ((pages < 100)); then
    echo "only $pages pages"
    exit 1
fi
if [[ -n "$warnings" ]]; then
    echo "$warnings"
    exit 1
fi
echo "$pages pages"
