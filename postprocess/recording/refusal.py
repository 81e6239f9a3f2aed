# SPDX-License-Identifier: BSD-3-Clause
"""The refusal of a bad recording, and the exit code that follows."""
from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

EXIT_BAD_INPUT = 2
Table = list[tuple[str, list]]  # name and values of each column


class Refusal(Exception):
    """The input is bad; the text is the reason. `is_complete`: it names the file."""

    def __init__(self, text: str, is_complete: bool = False):
        super().__init__(text)
        self.is_complete = is_complete


def exit_code_of(recording: Path, work: Callable[[], None]) -> int:
    """Does the work. If the input is bad, the reason is printed in one sentence."""
    try:
        work()
    except Refusal as error:
        reason = str(error) if error.is_complete else f"{recording}: {' '.join(str(error).split())}"
        print(f"culm: {reason}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"culm: {error.filename or recording}: cannot be read: {error.strerror}", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0
