# SPDX-License-Identifier: BSD-3-Clause
"""Every header of src/ compiles alone and may be included twice.

    headers.py ROOT COMPILE_COMMANDS    exit code 1 and the compiler's message for each that fails

The build itself shows that a header compiles alone if a source includes it first. A header that
another one includes first compiles alone if that one does. Only the others are compiled here,
without code generation. What several of them have in common is compiled once before (precompiled).
"""

import json
import re
import shlex
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from source_tree import files

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
# Only comments stand before the first include.
BEGINNING = re.compile(r'\A(?:\s|//.*$|#pragma once$)*#include "([^"]+)"', re.MULTILINE)
# Headers of libraries that take long to read; headers of src/ with the same ones are compared.
HEAVY = ("experimental/simd", "Eigen/Core")

# The compiler with its flags, and the folder in which it runs.
Compiler = tuple[list[str], str]


def source_of(entry: dict) -> Path:
    """The source of an entry; for a group of sources the first, which is included first."""
    path = Path(entry["file"])
    if path.parent.name != "Unity" or not path.is_file():
        return path
    match = INCLUDE.search(path.read_text(encoding="utf-8"))
    return Path(match.group(1)) if match else path


def build_flags(root: Path, commands: list[dict]) -> dict[str, Compiler]:
    """Folder of src/ -> compiler with flags, and its folder; tests provide header-only layers."""
    flags: dict[str, Compiler] = {}
    for tree in ("src", "tests"):
        for entry in commands:
            path = source_of(entry)
            if not path.is_relative_to(root / tree):
                continue
            arguments = shlex.split(entry["command"])
            layer = path.relative_to(root / tree).parts[0]
            flags.setdefault(layer, (arguments[: arguments.index("-o")], entry["directory"]))
    return flags


def proven_by_the_build(commands: list[dict]) -> set[str]:
    """Headers that are the first include of a source, as written there."""
    first = set()
    for entry in commands:
        path = source_of(entry)
        match = path.is_file() and INCLUDE.search(path.read_text(encoding="utf-8"))
        if match:
            first.add(match.group(1))
    return first


def to_compile(texts: dict[str, str], proven: set[str]) -> list[str]:
    """The headers that neither the build proves nor another header that includes them first."""
    first = {name: match.group(1) for name, text in texts.items()
             if (match := BEGINNING.match(text))}
    done = set()
    for name in [*proven, *texts]:
        name = name if name in proven else first.get(name)
        while name and name not in done:
            done.add(name)
            name = first.get(name)
    return [name for name in texts if name not in done]


def all_includes(texts: dict[str, str], header: str) -> set[str]:
    """What a header includes, itself or by other headers of src/; with the header."""
    seen, todo = set(), [header]
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo += INCLUDE.findall(texts.get(name, ""))
    return seen


def options(arguments: list[str]) -> list[tuple[str, ...]]:
    """The arguments, each with its value."""
    rest = iter(arguments)
    return [(name, next(rest)) if name == "-isystem" else (name,) for name in rest]


def precompile(folder: Path, compilers: list[Compiler], headers: set[str]) -> Path:
    """A header with some includes, compiled with the flags that all compilers have in common. A
    compiler whose other flags do not fit reads the header itself."""
    common = folder / "common.hpp"
    # Sorted, so that the headers of libraries, which depend on nothing, come first.
    system = sorted(name for name in headers if "/" not in name or name in HEAVY)
    common.write_text("".join(f"#include <{name}>\n"
                              for name in [*system, *sorted(headers.difference(system))]), "utf-8")
    arguments, directory = compilers[0]
    common_options = set.intersection(*(set(options(each)) for each, _ in compilers))
    flags = [word for option in options(arguments) if option in common_options for word in option]
    subprocess.run([*flags, "-O0", "-x", "c++-header", common, "-o", f"{common}.gch"],
                   cwd=directory, capture_output=True, check=False)
    return common


def compile_alone(header: str, compiler: Compiler, common: Path) -> str:
    """The compiler's message for a source that contains only this header; empty if it compiles."""
    arguments, directory = compiler
    source = f'#include "{header}"\n#include "{header}"\n'
    result = subprocess.run(
        [*arguments, "-O0", "-fsyntax-only", "-include", common, "-x", "c++", "-"], input=source,
        cwd=directory, capture_output=True, text=True, check=False)
    return "" if result.returncode == 0 else f"{header}:\n{result.stderr}"


def faults(root: Path, commands: list[dict]) -> list[str]:
    """The messages for all headers that are at fault."""
    compilers = build_flags(root, commands)
    texts = {path.relative_to(root / "src").as_posix(): path.read_text(encoding="utf-8")
             for path in files(root, ["src"], {".hpp"})}
    found = [f"{name}: has no #pragma once" for name, text in texts.items()
             if "\n#pragma once\n" not in f"\n{text}"]
    included = {name: all_includes(texts, name) for name in texts}
    groups = defaultdict(list)  # by the heavy headers
    for name in to_compile(texts, proven_by_the_build(commands)):
        layer = Path(name).parts[0]
        if layer not in compilers:
            found.append(f"{name}: no source or test of src/{layer} is in the build")
        else:
            groups[tuple(heavy in included[name] for heavy in HEAVY)].append(name)
    for names in groups.values():
        shared = set.intersection(*(included[name] for name in names)).difference(names)
        with tempfile.TemporaryDirectory() as folder:
            compiler = {name: compilers[Path(name).parts[0]] for name in names}
            common = precompile(Path(folder), list(compiler.values()), shared)
            found += filter(None, [compile_alone(name, compiler[name], common) for name in names])
    count = sum(map(len, groups.values()))
    print(f"{count} headers compiled alone, which proves {len(texts)} with the build")
    return found


if __name__ == "__main__":
    broken = faults(Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text(encoding="utf-8")))
    print("\n".join(broken) or "every header compiles alone")
    sys.exit(1 if broken else 0)
