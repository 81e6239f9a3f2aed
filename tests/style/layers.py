# SPDX-License-Identifier: BSD-3-Clause
"""Includes and links may only follow the arrows between the layers of src/.

    layers.py ROOT      exit code 1 and one line per fault if an arrow is broken
"""

import re
import sys
from pathlib import Path

from source_tree import files

# Folder of src/ -> the folders that it may include and link, besides itself; lowest layer first.
ALLOWED: dict[str, set[str]] = {
    "core": set(),
    "physics": {"core"},
    "archive": {"core"},
    "farm": {"core"},
    "integrate": {"core", "physics"},
    "measure": {"core", "physics"},
    "run": {"core", "physics", "integrate", "measure"},
    "reduce": {"core"},
    "study": {"core", "physics", "archive", "farm", "measure", "run", "reduce"},
    "fit": {"core", "physics", "farm", "integrate", "measure", "run", "reduce"},
}
ALLOWED["residuals"] = ALLOWED["fit"] | {"fit"}
ALLOWED["diagnose"] = ALLOWED["residuals"] | {"residuals"}
ALLOWED["calibrate"] = ALLOWED["diagnose"] | {"diagnose"}
ALLOWED["cluster"] = {"core"}
ALLOWED["present"] = (ALLOWED["calibrate"] | {"archive", "calibrate", "study"}) - {"farm"}
ALLOWED["cli"] = ALLOWED["calibrate"] | {"archive", "calibrate", "cluster", "present", "study"}

# Library -> patterns of its headers and CMake targets, and the folders that may use it. If a folder
# is a part of a layer, only that part may include the library.
LIBRARIES = {
    "MPI": (r"mpi\.h$", r"MPI::", {"farm", "cli"}),
    "HDF5": (r"(hdf5|H5\w*)\.h$", r"hdf5::|HDF5_", {"archive"}),
    "SUNDIALS": (
        r"(sundials|arkode|cvodes?|idas?|kinsol|nvector|sunmatrix|sunlinsol|sunnonlinsol)/",
        r"SUNDIALS::",
        {"integrate/sundials"},
    ),
    "toml++": (r"toml\+\+/", r"tomlplusplus::", {"core/toml", "study"}),
    "OpenCV": (r"opencv2/", r"OpenC[vV]::", {"measure/track"}),
}

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
LINK = re.compile(r"\bculm(?:::|_)(\w+)")


def names(layers: set[str]) -> str:
    return ", ".join(sorted(layers)) or "the tests"


def strip_cmake_comments(text: str) -> str:
    return re.sub(r"#.*", "", text)


def include_faults(place: str, layer: str, headers: list[str]) -> list[str]:
    """Faults of one source: it includes a higher layer or a library of another layer."""
    faults = []
    for header in headers:
        target = header.split("/")[0] if "/" in header else ""
        if target in ALLOWED and target != layer and target not in ALLOWED[layer]:
            faults.append(f"{place}: {layer} must not include {header}")
        if header.startswith("../") or "/../" in header:
            faults.append(f"{place}: {header} must be named from src/")
        for library, (pattern, _, owners) in LIBRARIES.items():
            if re.match(pattern, header) and not any(
                    place.startswith(f"src/{owner}/") for owner in owners):
                faults.append(f"{place}: {library} ({header}) belongs to {names(owners)}")
    return faults


def link_faults(place: str, layer: str, text: str) -> list[str]:
    """Faults of one src/<layer>/CMakeLists.txt, by the same rules."""
    faults = []
    for target in LINK.findall(text):
        if target in ALLOWED and target != layer and target not in ALLOWED[layer]:
            faults.append(f"{place}: {layer} must not link culm::{target}")
    for library, (_, pattern, owners) in LIBRARIES.items():
        if re.search(pattern, text) and layer not in {owner.split("/")[0] for owner in owners}:
            faults.append(f"{place}: {library} belongs to {names(owners)}")
    return faults


def faults(root: Path) -> list[str]:
    """All faults below ROOT/src."""
    found = []
    for folder in sorted(path for path in (root / "src").iterdir() if path.is_dir()):
        if folder.name not in ALLOWED:
            found.append(f"src/{folder.name}: a layer that tests/style/layers.py does not know")
    for path in files(root, ["src"], {".hpp", ".cpp", ".txt"}):
        place = str(path.relative_to(root))
        layer = path.relative_to(root / "src").parts[0]
        if layer not in ALLOWED:
            continue
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".txt":
            found += link_faults(place, layer, strip_cmake_comments(text))
        else:
            found += include_faults(place, layer, INCLUDE.findall(text))
    return found


if __name__ == "__main__":
    broken = faults(Path(sys.argv[1]))
    print("\n".join(broken) or "every include and link follows the layers")
    sys.exit(1 if broken else 0)
