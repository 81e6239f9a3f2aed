# SPDX-License-Identifier: BSD-3-Clause
"""Finds D3, the drawing library that the page contains."""
from __future__ import annotations

import re
from pathlib import Path

DEBIAN_FILE = Path("/usr/share/javascript/d3/d3.min.js")
HOW_TO_GET_IT = ("install Debian's libjs-d3 (jobs/install-packages.sh report), or name the file of "
                 "D3 version 3 by --d3-js")
VERSION = re.compile(r"""d3\s*=\s*\{\s*version:\s*["'](3\.\d+\.\d+)["']""")


class LibraryMissing(Exception):
    """There is no usable D3; one sentence."""


def d3_js(given: Path | None = None) -> tuple[str, str]:
    """Source text, safe inside a script element, and version of D3."""
    file = given or DEBIAN_FILE
    if not file.is_file() and given is None:
        raise LibraryMissing(f"D3 is not installed: {HOW_TO_GET_IT}.")
    try:
        source = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise LibraryMissing(f"{file}: cannot be read: {error}; {HOW_TO_GET_IT}.") from error
    version = VERSION.search(source)
    if version is None:
        raise LibraryMissing(f"{file}: is not D3 version 3; {HOW_TO_GET_IT}.")
    harmless = re.sub(r"</(script)", r"<\\/\1", source, flags=re.IGNORECASE)
    return harmless.replace("<!--", "<\\!--"), version[1]
