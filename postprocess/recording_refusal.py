# SPDX-License-Identifier: BSD-3-Clause
"""What the readers of recordings share."""
from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

EXIT_BAD_INPUT = 2
Table = list[tuple[str, list]]  # name and values of each column


class Refusal(Exception):
    """The input is bad; the text is the reason."""


def exit_code_of(recording: Path, work: Callable[[], None]) -> int:
    """Does the work. If the input is bad, the reason is printed in one sentence."""
    try:
        work()
    except Refusal as error:
        print(f"{recording}: {' '.join(str(error).split())}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"{error.filename or recording}: {error.strerror}", file=sys.stderr)
        return EXIT_BAD_INPUT
    return 0
