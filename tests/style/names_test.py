# SPDX-License-Identifier: BSD-3-Clause
"""Tests the check of names and first lines."""

import tempfile
import unittest
from pathlib import Path
from unittest import mock

import names

LICENCE = "// SPDX-License-Identifier: BSD-3-Clause\n"
HEADER = LICENCE + "// The length of a stem.\n#pragma once\n"
UNFINISHED = "// TO" "DO: later\n"


class NameCheck(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def faults_of(self, name: str, text: str) -> list[str]:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return names.faults(self.root)

    def test_a_good_header_is_accepted(self):
        self.assertEqual(self.faults_of("src/core/length.hpp", HEADER), [])

    def test_a_missing_licence_line_is_found(self):
        self.assertEqual(len(self.faults_of("src/core/a.cpp", "#include <vector>\n")), 1)

    def test_the_licence_line_of_a_script_may_follow_the_interpreter(self):
        text = "#!/bin/bash\n# SPDX-License-Identifier: BSD-3-Clause\n"
        self.assertEqual(self.faults_of("jobs/a.sh", text), [])

    def test_a_header_without_purpose_is_found(self):
        self.assertEqual(len(self.faults_of("src/core/a.hpp", LICENCE + "#pragma once\n")), 1)

    def test_a_header_without_guard_is_found(self):
        self.assertEqual(len(self.faults_of("src/core/a.hpp", LICENCE + "// A length.\n")), 1)

    def test_a_vague_name_is_found(self):
        for name in ("src/core/utils.hpp", "src/run/step_helpers.hpp", "src/common/a.hpp"):
            with self.subTest(name):
                self.setUp()
                self.assertEqual(len(self.faults_of(name, HEADER)), 1)

    def test_words_that_merely_contain_a_vague_one_are_accepted(self):
        self.assertEqual(self.faults_of("src/core/commonality.hpp", HEADER), [])

    def test_unfinished_work_is_found(self):
        self.assertEqual(len(self.faults_of("src/core/a.hpp", HEADER + UNFINISHED)), 1)

    def test_a_machine_path_is_found(self):
        for path in ("/home/someone/x", "/tmp", "`/wo" "rk/x`", "'/root/.config'"):
            with self.subTest(path):
                self.assertEqual(len(self.faults_of("docs/a.md", f"see {path}\n")), 1)
        self.assertEqual(len(self.faults_of("README.md", "see /home/someone\n")), 2)

    def test_a_path_below_a_named_folder_is_accepted(self):
        text = "DIR/tmp ~/work ${DIR}/home /workspaces and/or /root-mean-square x/work\n"
        self.assertEqual(self.faults_of("docs/a.md", text), [])

    def test_a_file_of_more_than_500_lines_is_an_error_and_of_more_than_400_a_warning(self):
        self.assertEqual(len(self.faults_of("src/core/a.hpp", HEADER + "\n" * 498)), 1)
        self.assertEqual(self.faults_of("src/core/a.hpp", HEADER + "\n" * 497), [])
        self.assertEqual(len(names.long_files(self.root)), 1)
        self.assertEqual(self.faults_of("src/core/a.hpp", HEADER + "\n" * 397), [])
        self.assertEqual(names.long_files(self.root), [])

    def test_a_crowded_folder_is_found(self):
        for number in range(names.MOST_IN_FOLDER):
            self.assertEqual(self.faults_of(f"src/core/a{number}.hpp", HEADER), [])
        self.assertEqual(len(self.faults_of("src/core/last.hpp", HEADER)), 1)

    def test_too_many_files_and_lines_are_found(self):
        with mock.patch.multiple(names, AIM_FILES=1, MOST_FILES=2, AIM_LINES=5, MOST_LINES=10):
            self.faults_of("src/core/a.hpp", HEADER)
            self.assertEqual(self.faults_of("src/core/b.hpp", HEADER), [])
            self.assertEqual(len(self.faults_of("src/core/b.hpp", HEADER + "\n" * 10)), 1)
            self.assertEqual(len(self.faults_of("src/core/c.hpp", HEADER)), 2)


if __name__ == "__main__":
    unittest.main()
