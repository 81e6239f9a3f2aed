# SPDX-License-Identifier: BSD-3-Clause
"""The parts of the page that `culm report` writes (docs/report.md); report.py assembles them."""
