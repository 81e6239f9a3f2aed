# SPDX-License-Identifier: BSD-3-Clause
"""Runs clang-tidy on every source of src/, in groups of sources.

    cmake --preset tidy && tests/style/tidy.py build/tidy [PART OF A PATH...]

Most of the time is spent on the headers of other projects. Sources with the same flags are
therefore included by one file, which the analyzer treats as a unit if its name begins with
UnifiedSource. Prints the findings; exit code 1 if there are any. CLANG_TIDY names the program.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

SOURCES_A_UNIT = 8
ROOT = Path(__file__).resolve().parents[2]


def units(database: list[dict], parts: list[str]) -> dict[str, list[str]]:
    """Name of a unit -> the command without its source, followed by the sources."""
    alike = defaultdict(list)
    for entry in sorted(database, key=lambda each: each["file"]):
        path = Path(entry["file"])
        if not path.is_relative_to(ROOT / "src") or path.suffix != ".cpp":
            continue
        layer = path.relative_to(ROOT / "src").parts[0]
        if not parts or any(part in str(path) for part in parts):
            alike[layer, entry["command"].split(" -o ")[0]].append(str(path))
    found = {}
    for (layer, command), sources in alike.items():
        for begin in range(0, len(sources), SOURCES_A_UNIT):
            name = f"UnifiedSource_{layer}_{len(found)}.cpp"
            found[name] = [command, *sources[begin:begin + SOURCES_A_UNIT]]
    return found


def findings(folder: Path, name: str) -> list[str]:
    """Findings of clang-tidy in one unit, without those about the unit's own includes."""
    result = subprocess.run(
        [os.environ.get("CLANG_TIDY", "clang-tidy"), "-p", folder, folder / name, "--quiet",
         f"--config-file={ROOT / '.clang-tidy'}", "--checks=-bugprone-suspicious-include",
         f"--header-filter={re.escape(str(ROOT))}/src/.*[.][ch]pp$"],
        capture_output=True, text=True, check=False)
    lines = result.stdout.splitlines()
    if result.returncode != 0 and not lines:
        lines = [f"{name}: clang-tidy failed: {result.stderr.strip()}"]
    return lines


def main(build: Path, parts: list[str]) -> int:
    database = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    number = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        commands = []
        wanted = units(database, parts)
        for unit, (command, *sources) in wanted.items():
            includes = "".join(f'#include "{source}"\n' for source in sources)
            (folder / unit).write_text(includes, encoding="utf-8")
            commands.append({"directory": str(build.resolve()), "file": str(folder / unit),
                             "command": f"{command} -c {folder / unit}"})
        (folder / "compile_commands.json").write_text(json.dumps(commands), encoding="utf-8")
        for unit, (_, *sources) in wanted.items():
            lines = findings(folder, unit)
            number += sum(": warning: " in line or ": error: " in line for line in lines)
            print("\n".join([f"{unit}: {len(sources)} sources", *lines]), flush=True)
    print(f"{number} findings in {sum(len(each) - 1 for each in wanted.values())} sources")
    return 1 if number else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
