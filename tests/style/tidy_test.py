# SPDX-License-Identifier: BSD-3-Clause
"""tidy.py must find faults, also those of the analyzer, in sources that only a unit includes."""

import json
import shutil
import sys
import tempfile
import unittest
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from unittest.mock import patch

import tidy

SOUND = "int twice(int n) { return 2 * n; }\n"
NULL_POINTER = "int read(int n) { int* p = nullptr; return n > 3 ? *p : n; }\n"  # a path's fault
COPY = "#include <string>\nint length(const std::string s) { return int(s.size()); }\n"


class Tidy(unittest.TestCase):
    def run_on(self, *sources: str) -> tuple[int, str]:
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            (root / "src" / "core").mkdir(parents=True)
            shutil.copy(tidy.ROOT / ".clang-tidy", root)
            database = []
            for number, text in enumerate(sources):
                source = root / "src" / "core" / f"source_{number}.cpp"
                source.write_text(text, encoding="utf-8")
                database.append({"directory": name, "file": str(source),
                                 "command": f"c++ -std=c++20 -o x.o -c {source}"})
            (root / "compile_commands.json").write_text(json.dumps(database), encoding="utf-8")
            printed = StringIO()
            with patch.object(tidy, "ROOT", root), redirect_stdout(printed):
                return tidy.main(root, []), printed.getvalue()

    def test_sound_sources_pass(self):
        code, printed = self.run_on(SOUND, SOUND.replace("twice", "again"))
        self.assertEqual(code, 0, printed)
        self.assertIn("0 findings in 2 sources", printed)

    def test_faults_of_any_source_are_found(self):
        code, printed = self.run_on(SOUND, NULL_POINTER, COPY)
        self.assertEqual(code, 1)
        self.assertIn("source_1.cpp", printed)
        self.assertIn("Dereference of null pointer", printed)
        self.assertIn("performance-unnecessary-value-param", printed)


if __name__ == "__main__":
    if shutil.which("clang-tidy") is None:
        print("clang-tidy is not installed")
        sys.exit(77)
    unittest.main()
