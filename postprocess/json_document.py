# SPDX-License-Identifier: BSD-3-Clause
"""Reads the JSON documents that culm's commands write, and says in a sentence what is wrong."""
from __future__ import annotations

import json
from pathlib import Path


def read_document(file: Path, command: str, name: str, error_type: type[Exception]) -> dict:
    """The document "culm-<name>", version 1, of `culm <command>`; error_type if it is none."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise error_type(f"{file}: {error.strerror}.") from error
    except ValueError as error:
        raise error_type(f"{file}: not JSON: {error}.") from error
    if (not isinstance(content, dict) or content.get("format") != f"culm-{name}"
            or content.get("version") != 1):
        raise error_type(f"{file}: not written by this version of culm {command}.")
    return content
