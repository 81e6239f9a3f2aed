# SPDX-License-Identifier: BSD-3-Clause
"""What the readers of recordings share."""
from __future__ import annotations

EXIT_BAD_INPUT = 2
Table = list[tuple[str, list]]  # name and values of each column


class Refusal(Exception):
    """The input is bad; the text is the reason."""
