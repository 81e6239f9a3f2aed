#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes a measurement from a recording of another program, or proposes a mapping for it.

`culm import` calls this program (docs/measurements.md). MAPPING.toml says what the columns or markers
of a recording are; of a recording itself a mapping is proposed as DIR/import.toml. Exit codes: 0
done, 2 bad input.
"""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from needed_packages import require
from recording.refusal import Refusal, exit_code_of


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, usage="%(prog)s MAPPING.toml|RECORDING --output DIR [option...]",
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", metavar="MAPPING.toml|RECORDING", type=Path)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True)
    parser.add_argument("--recording", metavar="FILE", type=Path,
                        help="the recording, instead of the one that the mapping names")
    parser.add_argument("--culm-track", metavar="PROGRAM", default="culm-track",
                        help="finds the release")
    parser.add_argument("--stem-faults", metavar="TEXT", default="",
                        help="mistakes in the mapping's tables on the stem, which culm has checked")
    return parser.parse_args(arguments)


def import_measurement(options: argparse.Namespace):
    from recording.mapping_file import read_mapping
    from recording.measured_rows import measured_rows
    from recording.measurement_folder import write_measurement
    from recording.plausible_stiffness import modulus_note
    from recording.printed_summary import print_measurement
    from recording.recorded_file import recorded_table
    mapping = read_mapping(options.input, options.recording, options.stem_faults)
    try:
        table = recorded_table(mapping.source, mapping.text,
                               [mapping.time_column or "", *mapping.names_used()])
        measured = measured_rows(table, mapping, options.culm_track)
    except Refusal as error:
        raise Refusal(f"{mapping.source}: {' '.join(str(error).split())}", True) from None
    if note := modulus_note(measured, mapping):
        measured.notes.append(note)
    write_measurement(options.output, mapping, measured)
    print_measurement(options.output, measured)


def work(options: argparse.Namespace):
    if options.input.suffix == ".toml":
        import_measurement(options)
        return
    from recording.proposal import propose
    print("\n".join(propose(options.input, options.output)))


def main(arguments: list[str] | None = None) -> int:
    require("numpy", "pandas", "scipy", "h5py")
    options = parse(arguments)
    return exit_code_of(options.input, lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
