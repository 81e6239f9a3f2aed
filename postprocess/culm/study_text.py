# SPDX-License-Identifier: BSD-3-Clause
"""A study as a dict, written as the TOML that culm reads. Python's library only reads TOML."""
from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence

from culm.program import InputError

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def study_text(study: Mapping) -> str:
    """The TOML text of a study: {"stem": {"spheres": 56}, "factors": {…}}. Numbers of numpy are
    numbers, arrays are lists. Raises InputError for a value that TOML does not have."""
    lines = [f"{_key(key)} = {_value(value, key)}" for key, value in study.items()
             if not isinstance(value, Mapping)]
    for table, content in study.items():
        if isinstance(content, Mapping):
            lines += ["", f"[{_key(table)}]"]
            lines += [f"{_key(key)} = {_value(value, f'{table}.{key}')}"
                      for key, value in content.items()]
    return "\n".join(lines).strip() + "\n"


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else json.dumps(key)


def _value(value, where: str) -> str:
    if hasattr(value, "tolist"):  # an array or a number of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, int) or (isinstance(value, float) and math.isfinite(value)):
        return repr(value)
    if isinstance(value, Mapping):
        inside = (f"{_key(key)} = {_value(item, f'{where}.{key}')}" for key, item in value.items())
        return "{" + ", ".join(inside) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(item, where) for item in value) + "]"
    raise InputError(f"{where} = {value!r}: a study holds texts, finite numbers, booleans, lists "
                     "and dicts")
