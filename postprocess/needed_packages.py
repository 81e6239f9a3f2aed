# SPDX-License-Identifier: BSD-3-Clause
"""Reports missing modules in one sentence instead of a traceback."""
from __future__ import annotations

import os
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

EXIT_BAD_INPUT = 2
SYSTEM_PYTHON = "/usr/bin/python3"


def require(*modules: str):
    """If one of the modules is not installed, starts the program again with the Python that the
    variable CULM_PYTHON names, or with the system's, or else ends it."""
    missing = [module for module in modules if find_spec(module) is None]
    if not missing:
        return
    tried = os.environ.get("CULM_TRIED_PYTHON", "")
    other = next((path for path in (shutil.which(os.environ.get("CULM_PYTHON", "")), SYSTEM_PYTHON)
                  if path and os.path.exists(path) and path != tried
                  and not os.path.samefile(path, sys.executable)), None)
    if other:
        os.environ["CULM_TRIED_PYTHON"] = sys.executable
        os.execv(other, [other, "-B", *sys.argv])
    print(f"{Path(sys.argv[0]).name}: {sys.executable} lacks {' and '.join(missing)}: "
          "jobs/install-packages.sh figures installs what is needed for Debian's /usr/bin/python3 "
          "(the variable CULM_PYTHON names the Python to use).", file=sys.stderr)
    sys.exit(EXIT_BAD_INPUT)
