# SPDX-License-Identifier: BSD-3-Clause
"""Finds plotly.js, which the page carries within it."""
from __future__ import annotations

import importlib.util
import re
from pathlib import Path

# Of Debian's package r-cran-plotly, and where other packages put libraries for browsers.
DEBIAN_FILES = (
    "/usr/lib/R/site-library/plotly/htmlwidgets/lib/plotlyjs/plotly-latest.min.js",
    "/usr/share/javascript/plotly/plotly.min.js",
    "/usr/share/javascript/plotly.js/plotly.min.js",
)
HOW_TO_GET_IT = ("install Debian's r-cran-plotly (jobs/install-packages.sh report), or pip's "
                 "plotly, or name a file by --plotly-js")
BANNER = re.compile(r"plotly(?:\.js)?(?: \([\w -]+\))? v?(\d+\.\d+\.\d+)")


class LibraryMissing(Exception):
    """There is no usable plotly.js; one sentence."""


def _of_the_python_package() -> list[Path]:
    found = importlib.util.find_spec("plotly")
    folders = list(found.submodule_search_locations or []) if found else []
    return [Path(folder) / "package_data" / "plotly.min.js" for folder in folders]


def candidates() -> list[Path]:
    """Where it is looked for, in this order."""
    return _of_the_python_package() + [Path(name) for name in DEBIAN_FILES]


def plotly_js(given: Path | None = None) -> tuple[str, str]:
    """Source text, safe inside a script element, and version of plotly.js."""
    file = given or next((file for file in candidates() if file.is_file()), None)
    if file is None:
        raise LibraryMissing(f"plotly.js is not installed: {HOW_TO_GET_IT}.")
    try:
        source = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise LibraryMissing(f"{file}: cannot be read: {error}; {HOW_TO_GET_IT}.") from error
    version = BANNER.search(source[:1000])
    if version is None:
        raise LibraryMissing(f"{file}: is not plotly.js; {HOW_TO_GET_IT}.")
    harmless = re.sub(r"</(script)", r"<\\/\1", source, flags=re.IGNORECASE)
    return harmless.replace("<!--", "<\\!--"), version[1]
