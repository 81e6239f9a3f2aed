# SPDX-License-Identifier: BSD-3-Clause
"""Reports missing modules in one sentence instead of a traceback."""
from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

EXIT_BAD_INPUT = 2


def require(*modules: str):
    """Ends the program if one of the modules is not installed."""
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        print(f"{Path(sys.argv[0]).name}: {sys.executable} lacks {' and '.join(missing)}: "
              "jobs/install-packages.sh figures installs what is needed for Debian's "
              f"/usr/bin/python3 (then: /usr/bin/python3 {' '.join(sys.argv)}).", file=sys.stderr)
        sys.exit(EXIT_BAD_INPUT)
