#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes a folder of results as one page: report.py DIR -o report.html.

`culm report` calls this program (docs/report.md). DIR, or folders in it, may contain the results
that `culm run`, `track`, `fit`, `calibrate`, `compare` and `diagnose` write with -o. The page needs
no network. Prints its path. Exit codes: 0 done, 2 bad input or something missing on this machine.
"""
from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from needed_packages import require

EXIT_BAD_INPUT = 2
PROGRAM = "culm report"


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description="Writes a folder of results as one page with figures.")
    parser.add_argument("directory", metavar="DIR", type=Path,
                        help="folder of results, or of such folders")
    parser.add_argument("-o", "--output", metavar="FILE", type=Path,
                        help="the page to write (DIR/report.html)")
    parser.add_argument("--d3-js", metavar="FILE", type=Path,
                        help="the drawing library, if it is not found")
    return parser.parse_args(arguments)


def refuse(sentence) -> int:
    print(f"{PROGRAM}: {sentence}", file=sys.stderr)
    return EXIT_BAD_INPUT


def write_whole(file: Path, text: str):
    """Replaces the page as a whole, so that an error never leaves half a page."""
    file.parent.mkdir(parents=True, exist_ok=True)
    unfinished = file.with_name(file.name + ".tmp")
    try:
        unfinished.write_text(text, encoding="utf-8")
        os.replace(unfinished, file)
    except OSError:
        unfinished.unlink(missing_ok=True)
        raise


def main(arguments=None) -> int:
    options = parse(arguments)
    require("numpy", "h5py")
    from report_page.contents import REFUSALS, NothingToReport, sections_of
    from report_page.library import LibraryMissing, d3_js
    from report_page.page import page_of
    output = options.output or options.directory / "report.html"
    try:
        library, version = d3_js(options.d3_js)
        sections = sections_of(options.directory, output.parent)
        name = options.directory.resolve().name
        write_whole(output, page_of(name, sections, library, version))
    except (NothingToReport, LibraryMissing, *REFUSALS) as error:
        return refuse(error)
    except OSError as error:
        return refuse(f"{error.filename}: {error.strerror}.")
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
