# SPDX-License-Identifier: BSD-3-Clause
"""bench/publish.py finds pages that differ from their numbers, and numbers that are stale.

published_test.py FOLDER_OF_BENCH
"""

import importlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BENCH = Path(sys.argv.pop(1)) if len(sys.argv) > 1 else Path(__file__).parents[2] / "bench"
PAGE = "Some text\n<!-- published: {} -->\nold\n<!-- end -->\n"
TABLE = ("A title:\n\n| what | wall, s | share |\n|---|---:|---:|\n"
         "| tip | 1.50 | 12.0 % |\n| full | 1 234 | 1e-07 |\n")


class Published(unittest.TestCase):
    """A repository with one page, one source and one file of numbers."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = Path(scratch.name)
        shutil.copytree(BENCH, self.root / "bench", ignore=shutil.ignore_patterns("results"))
        for folder in ("docs", "src/core", "src/archive", "bench/results"):
            (self.root / folder).mkdir(parents=True, exist_ok=True)
        (self.root / "src/core/one.cpp").write_text("one\n")
        (self.root / "README.md").write_text("nothing\n")
        self.git("init", "-q")
        self.commit()
        sys.path.insert(0, str(self.root / "bench"))
        self.addCleanup(sys.path.remove, str(self.root / "bench"))
        for name in ("publish", "measure", "measurements", "block", "published_blocks", "rate_blocks",
                     "recording_blocks"):
            sys.modules.pop(name, None)
        self.publish = importlib.import_module("publish")
        self.measure = importlib.import_module("measure")

    def git(self, *words):
        subprocess.run(["git", "-C", self.root, "-c", "user.name=a", "-c", "user.email=a@b",
                        *words], check=True, capture_output=True)

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "change", "--allow-empty")

    def write_numbers(self):
        measurement = next(each for each in self.measure.MEASUREMENTS if each.name == "large-study")
        self.measure.write_result(measurement, {"cases": self.measure.table_rows(TABLE)})

    def test_rows_of_a_table_are_numbers_with_their_title(self):
        rows = [row for row in self.measure.table_rows(TABLE) if "table" in row]
        self.assertEqual(rows, [{"table": "A title", "what": "tip", "wall, s": 1.5, "share": 12.0},
                                {"table": "A title", "what": "full", "wall, s": 1234,
                                 "share": 1e-07}])

    def test_the_summary_begins_at_its_last_heading(self):
        printed = "case 1\nall: 1 of 2\n\ncase 2\nall: 2 of 2\nmore: 1\n"
        self.assertEqual(self.measure.summary_of(printed, "all:"), ["all: 2 of 2", "more: 1"])
        self.assertEqual(self.measure.summary_of(printed, ""), [])

    def test_a_page_gets_its_numbers_and_keeps_its_text(self):
        self.write_numbers()
        page = self.root / "docs/performance.md"
        made = self.publish.with_numbers(PAGE.format("large-study"), page)
        self.assertTrue(made.startswith("Some text\n<!-- published: large-study -->\n| what |"))
        self.assertIn("| tip |", made)
        self.assertEqual(self.publish.with_numbers(made, page), made)

    def test_a_page_that_differs_is_found(self):
        self.write_numbers()
        (self.root / "docs/performance.md").write_text(PAGE.format("large-study"))
        self.assertIn("performance.md differs from bench/results: run bench/publish.py",
                      self.publish.faults_of_pages())

    def test_an_unknown_block_is_found(self):
        (self.root / "docs/performance.md").write_text(PAGE.format("unheard-of"))
        faults = "\n".join(self.publish.faults_of_pages())
        self.assertIn("performance.md: no block unheard-of", faults)

    def test_a_commit_outside_of_a_block_is_found(self):
        (self.root / "docs/other.md").write_text("Measured with\ncommit 12ab34f.\n")
        self.assertIn("other.md:2: the commit 12ab34f outside of a block",
                      self.publish.faults_of_pages())

    def test_numbers_are_stale_when_their_sources_change(self):
        self.write_numbers()
        self.commit()
        self.assertEqual(self.publish.faults_of_age(), [])
        (self.root / "src/core/one.cpp").write_text(" one\n")
        self.assertEqual(self.publish.faults_of_age(), [], "only blanks changed")
        (self.root / "src/core/one.cpp").write_text("two\n")
        self.assertIn("large-study.json is of", "".join(self.publish.faults_of_age()))
        self.commit()
        self.assertIn("large-study.json is of", "".join(self.publish.faults_of_age()))

    def test_bound_of_an_error_rate_is_that_of_clopper_and_pearson(self):
        bound = importlib.import_module("rate_blocks").upper_bound
        # Of no error in n: 1 - 0.05^(1/n); of 2 in 313: below 2 % (Clopper & Pearson 1934).
        self.assertAlmostEqual(bound(0, 149), 1.0 - 0.05**(1.0 / 149), 9)
        self.assertLess(bound(2, 313), 0.0201)
        self.assertGreater(bound(3, 313), 0.0201)
        self.assertEqual(bound(5, 5), 1.0)

    def test_a_page_long_beyond_its_limit_is_found(self):
        (self.root / "docs/performance.md").write_text("line\n" * 201)
        self.assertIn("performance.md has 201 lines, 200 are allowed",
                      self.publish.faults_of_pages())

    def test_numbers_that_nobody_quotes_and_that_are_missing_are_found(self):
        (self.root / "bench/results/spare.json").write_text("{}\n")
        page = self.root / "docs/performance.md"
        page.write_text(self.publish.with_numbers(PAGE.format("large-study"), page))
        faults = self.publish.faults_of_files()
        self.assertIn("spare.json: no page quotes it", faults)
        self.assertIn("performance.md: large-study is not measured: run bench/publish.sh BUILD",
                      faults)


if __name__ == "__main__":
    unittest.main()
