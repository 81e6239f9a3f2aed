#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes an XDMF file for each stored trajectory of a study, for ParaView: trajectories_xdmf.py DIR -o XDMF

Each file points at the positions in DIR/study.h5, which may be links to files beside it, and copies
nothing. XDMF 2.2 (xdmf.org, "XDMF Model and Format"): a temporal collection with one polyline
through the spheres for each sample.
Exit codes: 0 done, 2 bad input.
"""
from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from xml.etree import ElementTree

from needed_packages import require

require("h5py", "numpy")
from culm.archive import Study  # noqa: E402

EXIT_BAD_INPUT = 2


def trajectory(archive: str, group: str, times, spheres: int,
               number_bytes: int) -> ElementTree.ElementTree:
    """`archive` is relative to the XDMF file; its dataset has the shape (samples, spheres, 3)."""
    def item(parent, text: str, **attributes):
        ElementTree.SubElement(parent, "DataItem", attributes).text = text

    root = ElementTree.Element("Xdmf", Version="2.2")
    collection = ElementTree.SubElement(ElementTree.SubElement(root, "Domain"), "Grid", Name=group,
                                        GridType="Collection", CollectionType="Temporal")
    for sample, time in enumerate(times):
        grid = ElementTree.SubElement(collection, "Grid", Name="stem")
        ElementTree.SubElement(grid, "Time", Value=repr(float(time)))
        topology = ElementTree.SubElement(grid, "Topology", TopologyType="Polyline",
                                          NumberOfElements="1", NodesPerElement=str(spheres))
        item(topology, " ".join(map(str, range(spheres))), Format="XML", NumberType="Int",
             Dimensions=f"1 {spheres}")
        geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
        slab = ElementTree.SubElement(geometry, "DataItem", ItemType="HyperSlab", Type="HyperSlab",
                                      Dimensions=f"{spheres} 3")
        item(slab, f"{sample} 0 0 1 1 1 1 {spheres} 3", Dimensions="3 3", NumberType="Int",
             Format="XML")
        item(slab, f"{archive}:/particles/{group}/position/value", Format="HDF",
             Precision=str(number_bytes), NumberType="Float", Dimensions=f"{len(times)} {spheres} 3")
    return ElementTree.ElementTree(root)


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder with a study.h5")
    parser.add_argument("-o", "--output", metavar="XDMF", type=Path, required=True,
                        help="folder for point_000012.xdmf and the others")
    arguments = parser.parse_args(arguments)
    try:
        with Study(arguments.directory) as study:
            if not study.stores_positions:
                raise ValueError(f"{arguments.directory}: the study stores no trajectories "
                                 '(study.store = "full" does)')
            arguments.output.mkdir(parents=True, exist_ok=True)
            archive = Path(os.path.relpath(arguments.directory / "study.h5", arguments.output))
            completed = study.is_completed.nonzero()[0]
            for point in completed:
                group = f"point_{point:06}"
                trajectory(archive.as_posix(), group, study.time, study.spheres,
                           study.position_bytes).write(
                    arguments.output / f"{group}.xdmf", encoding="unicode", xml_declaration=True)
    except (OSError, ValueError) as error:
        print(f"trajectories_xdmf: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    print(f"{len(completed)} trajectories in {arguments.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
