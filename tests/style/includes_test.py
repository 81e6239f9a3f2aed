# SPDX-License-Identifier: BSD-3-Clause
"""Tests the check of includes."""

import tempfile
import unittest
from pathlib import Path

import includes


class IncludeCheck(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.list = self.root / "accepted.txt"

    def write(self, name: str, *headers: str) -> None:
        path = self.root / "src" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(f'#include "{header}"\n' for header in headers), encoding="utf-8")

    def kinds(self) -> list[str]:
        return sorted(includes.faults(self.root))

    def test_a_header_with_two_clients_is_accepted(self):
        self.write("run/a.hpp")
        self.write("run/a.cpp", "run/a.hpp")
        self.write("run/b.cpp", "run/a.hpp")
        self.write("run/c.cpp", "run/a.hpp")
        self.assertEqual(self.kinds(), [])

    def test_headers_in_a_circle_are_found(self):
        self.write("run/a.hpp", "run/b.hpp")
        self.write("run/b.hpp", "run/c.hpp")
        self.write("run/c.hpp", "run/a.hpp")
        self.write("run/d.cpp", "run/a.hpp", "run/b.hpp", "run/c.hpp")
        self.assertEqual(self.kinds(), ["headers a.hpp b.hpp c.hpp", "units a b c"])

    def test_pairs_of_header_and_source_in_a_circle_are_found(self):
        self.write("run/a.hpp")
        self.write("run/a.cpp", "run/a.hpp", "run/b.hpp")
        self.write("run/b.hpp")
        self.write("run/b.cpp", "run/b.hpp", "run/a.hpp")
        self.write("run/c.cpp", "run/a.hpp", "run/b.hpp")
        self.assertEqual(self.kinds(), ["units a b"])

    def test_a_source_that_includes_its_own_header_is_not_a_circle(self):
        self.assertEqual(includes.circles({"a": {"a"}, "b": {"a"}}), [])

    def test_a_header_with_a_single_client_is_accepted(self):
        self.write("run/a.hpp")
        self.write("run/a.cpp", "run/a.hpp")
        self.write("run/deep/b.cpp", "run/a.hpp")
        self.assertEqual(self.kinds(), [])

    def test_a_header_without_a_client_is_found(self):
        self.write("run/a.hpp")
        self.write("run/a.cpp", "run/a.hpp")
        self.assertEqual(self.kinds(), ["unused a.hpp"])

    def test_an_accepted_fault_may_move_but_no_other_may_come(self):
        self.write("study/a.hpp")
        self.list.write_text("# a comment\nunused a.hpp\nunits a b c\n", encoding="utf-8")
        self.assertEqual(includes.new_faults(self.root, self.list, 2), [])
        self.write("study/x.hpp")
        self.assertEqual(len(includes.new_faults(self.root, self.list, 2)), 1)

    def test_a_part_of_an_accepted_circle_is_accepted(self):
        self.assertTrue(includes.is_accepted("units a b", ["units a b c"]))
        self.assertFalse(includes.is_accepted("units a d", ["units a b c"]))
        self.assertFalse(includes.is_accepted("headers a b", ["units a b c"]))

    def test_a_list_that_grows_is_found(self):
        self.list.write_text("unused a.hpp\nunused b.hpp\n", encoding="utf-8")
        self.assertEqual(includes.new_faults(self.root, self.list, 2), [])
        self.assertEqual(len(includes.new_faults(self.root, self.list, 1)), 1)

    def test_the_list_shrinks(self):
        self.write("run/a.hpp")
        self.list.write_text("# why\nunused a.hpp\nunused gone.hpp\n", encoding="utf-8")
        self.assertEqual(includes.shrink(self.root, self.list), 1)
        self.assertEqual(self.list.read_text("utf-8"), "# why\nunused a.hpp\n")


if __name__ == "__main__":
    unittest.main()
