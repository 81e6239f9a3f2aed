# SPDX-License-Identifier: BSD-3-Clause
"""Validates JSON by the part of JSON Schema that `culm schema` writes, without other packages."""

import json
import os
import subprocess

TYPES = {
    "object": dict, "array": list, "string": str, "boolean": bool, "null": type(None),
    "integer": int, "number": (int, float),
}
KEYWORDS = {"$schema", "$defs", "$ref", "title", "description", "type", "const", "enum", "oneOf",
            "properties", "required", "additionalProperties", "items", "minItems", "maxItems"}


def schema_of(name: str) -> dict:
    """The schema of one of culm's documents, as the program under test prints it."""
    finished = subprocess.run([os.environ["CULM_PROGRAM"], "schema", name], text=True,
                              capture_output=True, check=True)
    return json.loads(finished.stdout)


def has_type(value, names) -> bool:
    names = [names] if isinstance(names, str) else names
    return any(isinstance(value, TYPES[name]) and
               (name == "boolean" or not isinstance(value, bool)) for name in names)


def object_faults(value: dict, schema: dict, root: dict, place: str) -> list[str]:
    faults = [f"{place}: {key} is missing" for key in schema.get("required", ())
              if key not in value]
    for key, member in value.items():
        if key in schema.get("properties", {}):
            faults += schema_faults(member, schema["properties"][key], root, f"{place}.{key}")
        elif schema.get("additionalProperties", True) is False:
            faults.append(f"{place}: {key} is not in the schema")
        elif isinstance(schema.get("additionalProperties"), dict):
            faults += schema_faults(member, schema["additionalProperties"], root, f"{place}.{key}")
    return faults


def array_faults(value: list, schema: dict, root: dict, place: str) -> list[str]:
    faults = []
    if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
        faults.append(f"{place}: {len(value)} items")
    for index, item in enumerate(value):
        faults += schema_faults(item, schema.get("items", {}), root, f"{place}[{index}]")
    return faults


def schema_faults(value, schema: dict, root: dict | None = None, place: str = "$") -> list[str]:
    """The faults of a value, one sentence each; empty if it is valid."""
    root = root or schema
    unknown = set(schema) - KEYWORDS
    if unknown:
        return [f"{place}: this check does not know {sorted(unknown)}"]
    if "$ref" in schema:
        return schema_faults(value, root["$defs"][schema["$ref"].split("/")[-1]], root, place)
    if "oneOf" in schema:
        each = [schema_faults(value, choice, root, place) for choice in schema["oneOf"]]
        valid = sum(not faults for faults in each)
        return [] if valid == 1 else [f"{place}: {valid} of {len(each)} choices fit"] + sum(each, [])
    if "const" in schema and value != schema["const"]:
        return [f"{place}: {value!r} instead of {schema['const']!r}"]
    if "enum" in schema and value not in schema["enum"]:
        return [f"{place}: {value!r} is not one of {schema['enum']}"]
    if "type" in schema and not has_type(value, schema["type"]):
        return [f"{place}: {value!r} is not of type {schema['type']}"]
    if isinstance(value, dict):
        return object_faults(value, schema, root, place)
    if isinstance(value, list):
        return array_faults(value, schema, root, place)
    return []
