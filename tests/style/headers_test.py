# SPDX-License-Identifier: BSD-3-Clause
"""Tests the check of the headers on a small tree with one bad header.

    headers_test.py COMPILER
"""

import sys
import tempfile
import unittest
from pathlib import Path

import headers

COMPILER = sys.argv.pop(1)
COMPLETE = "#pragma once\n#include <vector>\ninline std::vector<int> lengths() { return {}; }\n"
INCOMPLETE = "#pragma once\ninline std::vector<int> lengths() { return {}; }\n"


class HeaderCheck(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def write(self, name: str, text: str) -> Path:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def faults_with(self, header: str, source: str) -> list[str]:
        self.write("src/core/lengths.hpp", header)
        path = self.write("src/core/user.cpp", source)
        command = f"{COMPILER} -std=c++20 -I{self.root / 'src'} -o user.o -c {path}"
        entry = {"directory": str(self.root), "command": command, "file": str(path)}
        return headers.faults(self.root, [entry])

    def test_a_complete_header_is_accepted(self):
        source = '#include <map>\n#include "core/lengths.hpp"\n'
        self.assertEqual(self.faults_with(COMPLETE, source), [])

    def test_a_header_that_leans_on_its_user_is_found(self):
        source = '#include <vector>\n#include "core/lengths.hpp"\n'
        faults = self.faults_with(INCOMPLETE, source)
        self.assertEqual(len(faults), 1)
        self.assertIn("core/lengths.hpp", faults[0])

    def test_a_heavy_header_that_only_others_include_is_missed(self):
        self.write("src/core/order.hpp", "#pragma once\n#include <algorithm>\n")
        text = "#pragma once\ninline int larger(int a, int b) { return std::max(a, b); }\n"
        self.assertEqual(len(self.faults_with(text, "#include <algorithm>\n")), 1)
        self.write("src/core/user.hpp", '#pragma once\n#include "core/order.hpp"\n'
                   '#include "core/larger.hpp"\n')
        self.write("src/core/larger.hpp", text)
        faults = self.faults_with(COMPLETE, "#include <algorithm>\n")
        self.assertEqual([fault.partition(":")[0] for fault in faults], ["core/larger.hpp"])

    def test_a_header_that_cannot_be_included_twice_is_found(self):
        text = COMPLETE.replace("#pragma once\n", "")
        faults = self.faults_with(text, "#include <map>\n")
        self.assertIn("has no #pragma once", faults[0])
        self.assertIn("redefinition", faults[1])

    def test_a_header_that_another_one_includes_first_is_proven_by_it(self):
        self.write("src/core/stem.hpp", '#pragma once\n#include "core/lengths.hpp"\n')
        self.assertEqual(headers.to_compile(
            {"core/stem.hpp": '// A stem.\n#pragma once\n\n#include "core/lengths.hpp"\n',
             "core/late.hpp": '#pragma once\n#include <vector>\n#include "core/order.hpp"\n',
             "core/lengths.hpp": COMPLETE, "core/order.hpp": COMPLETE}, set()),
            ["core/stem.hpp", "core/late.hpp", "core/order.hpp"])
        faults = self.faults_with(INCOMPLETE, "#include <vector>\n")
        self.assertIn("core/stem.hpp", faults[0])

    def test_a_header_that_a_source_includes_first_is_left_to_the_build(self):
        self.assertEqual(self.faults_with(INCOMPLETE, '#include "core/lengths.hpp"\n'), [])

    def test_a_group_of_sources_serves_as_its_first_one(self):
        self.write("src/core/lengths.hpp", INCOMPLETE)
        source = self.write("src/core/user.cpp", '#include <vector>\n#include "core/lengths.hpp"\n')
        group = self.write("build/src/core/Unity/unity_0_cxx.cxx", f'#include "{source}"\n')
        command = f"{COMPILER} -std=c++20 -I{self.root / 'src'} -o user.o -c {group}"
        entry = {"directory": str(self.root), "command": command, "file": str(group)}
        faults = headers.faults(self.root, [entry])
        self.assertEqual(len(faults), 1)
        self.assertIn("lengths", faults[0])

    def test_a_layer_outside_the_build_is_found(self):
        self.write("src/run/simulate.hpp", COMPLETE)
        self.assertEqual(len(self.faults_with(COMPLETE, "\n")), 1)


if __name__ == "__main__":
    unittest.main()
