# SPDX-License-Identifier: BSD-3-Clause
"""docs/howto.md is correct."""

import unittest

from executed_page import ROOT, ExecutedPage


class HowTo(ExecutedPage, unittest.TestCase):
    page = ROOT / "docs" / "howto.md"


if __name__ == "__main__":
    unittest.main()
