# SPDX-License-Identifier: BSD-3-Clause
"""Reads the HDF5 files of culm. Damage is reported as an error and never returned as a number, and
a file cannot make its reader open other files (docs/archive-format.md)."""
from __future__ import annotations

import re
import zlib
from pathlib import Path

import h5py
import numpy as np

FORMAT_NAME = "culm-study"
TRAJECTORY_FORMAT_NAME = "culm-trajectories"
FORMAT_MAJOR = 1


class StudyError(Exception):
    """A result folder cannot be read or does not hold what was asked for; one sentence."""


KINDS_OF_LINK = {h5py.h5l.TYPE_SOFT: "a soft link", h5py.h5l.TYPE_EXTERNAL: "an external link"}


def sentence(error: Exception) -> str:
    """An error of a library as the end of a sentence."""
    lines = str(error).strip().splitlines() or [type(error).__name__]
    return lines[0].rstrip(".") + "."


def own_object(file: h5py.File, path: Path, name: str):
    """The group or dataset `name` of the file, None if it is missing.

    Raises StudyError if its numbers or its name come from another file. External links, soft links
    to them, virtual datasets and external storage can refer to any file of this machine, and a page
    made from them would publish that file. trajectory() follows no link either.
    """
    place, way = file["/"], ""
    for part in (part for part in name.split("/") if part not in ("", ".")):
        encoded = part.encode("utf-8")
        if not isinstance(place, h5py.Group) or not place.id.links.exists(encoded):
            return None
        way += f"/{part}"
        kind = place.id.links.get_info(encoded).type
        if kind != h5py.h5l.TYPE_HARD:
            raise StudyError(f"{path}: {way} is {KINDS_OF_LINK.get(kind, 'a link')}"
                             f"{_target_of(place, encoded, kind)}: links are not followed.")
        place = place[part]
    if isinstance(place, h5py.Dataset) and (place.is_virtual or place.external):
        raise StudyError(f"{path}: {way} keeps its numbers in other files: they are not read.")
    return place


def _target_of(group: h5py.Group, name: bytes, kind: int) -> str:
    if kind == h5py.h5l.TYPE_EXTERNAL:
        file, item = group.id.links.get_val(name)
        return f" to {item.decode('utf-8', 'replace')} in {file.decode('utf-8', 'replace')}"
    if kind == h5py.h5l.TYPE_SOFT:
        return f" to {group.id.links.get_val(name).decode('utf-8', 'replace')}"
    return ""


class CheckedFile:
    """An open file of culm. Every failure is a StudyError that names the file and the object.

    HDF5 verifies the checksums of the chunks. This class verifies what HDF5 does not: the format,
    that no chunk is absent (HDF5 would read it as fill values), and the CRC-32 of texts.
    """

    def __init__(self, path: Path, format_name: str = FORMAT_NAME):
        self.path = path
        self._format_name = format_name
        self._whole: set[str] = set()
        try:
            self.file = h5py.File(path, "r", locking="best-effort")
        except OSError as error:
            text = f"{path} is not a readable HDF5 file: {sentence(error)}"
            raise StudyError(text) from error
        try:
            self._check_format()
        except BaseException:
            self.file.close()
            raise

    def __contains__(self, name: str) -> bool:
        return own_object(self.file, self.path, name) is not None

    def attribute(self, item: str, name: str):
        holder = own_object(self.file, self.path, item)
        try:
            return holder.attrs[name]
        except (AttributeError, KeyError):
            raise StudyError(f"{self.path}: {item} lacks the attribute '{name}'.") from None

    def text_list(self, group: str, attribute: str) -> list[str]:
        """An attribute that lists names; empty if the group does not have it."""
        holder = own_object(self.file, self.path, group)
        if holder is None:
            raise StudyError(f"{self.path}: the group /{group} is missing.")
        return [str(text) for text in holder.attrs.get(attribute, [])]

    def dataset(self, name: str) -> h5py.Dataset:
        item = own_object(self.file, self.path, name)
        if not isinstance(item, h5py.Dataset):
            raise StudyError(f"{self.path}: the dataset /{name} is missing.")
        return item

    def read(self, name: str, selection=()):
        """A dataset or a part of it; text as str."""
        dataset = self.dataset(name)
        self._require_all_chunks(name, dataset)
        is_text = h5py.check_string_dtype(dataset.dtype) is not None
        try:
            return dataset.asstr()[selection] if is_text else dataset[selection]
        except (OSError, UnicodeDecodeError) as error:
            raise StudyError(f"{self.path}: /{name} is damaged: {sentence(error)}") from error

    def trajectory(self, rank: int, number: int, slot: int, crc32: int) -> np.ndarray:
        """Positions in a file of the folder `trajectories`, (S, N, 3), verified by their CRC-32
        because HDF5 has no checksum for them."""
        path = self.path.parent / "trajectories" / f"rank-{rank:05d}-{number:04d}.h5"
        if not path.is_file():
            raise StudyError(f"{path} is missing; it holds trajectories of the study.")
        other = CheckedFile(path, TRAJECTORY_FORMAT_NAME)
        try:
            values = other.read(f"particles/trajectory_{slot:04d}/position/value")
        finally:
            other.file.close()
        values = np.ascontiguousarray(values, dtype="<f8")
        if zlib.crc32(values) != crc32:
            raise StudyError(f"{path}: trajectory_{slot:04d} is damaged: its checksum is wrong.")
        return values

    def text(self, name: str) -> str:
        """A scalar text, verified by its CRC-32 because HDF5 has no checksum for it."""
        text = str(self.read(name))
        if zlib.crc32(text.encode("utf-8")) != int(self.attribute(name, "crc32")):
            raise StudyError(f"{self.path}: /{name} is damaged: its checksum is wrong.")
        return text

    def _check_format(self):
        name = self.file.attrs.get("format")
        if name != self._format_name:
            found = "no format" if name is None else f"the format '{name}'"
            raise StudyError(
                f"{self.path} is not a study archive: it states {found}, not '{self._format_name}'."
            )
        version = str(self.file.attrs.get("format_version", ""))
        if not re.fullmatch(r"\d+\.\d+", version) or int(version.split(".")[0]) != FORMAT_MAJOR:
            raise StudyError(
                f"{self.path} has format version '{version}'; this reader knows {FORMAT_MAJOR}.x."
            )

    def _require_all_chunks(self, name: str, dataset: h5py.Dataset):
        if dataset.chunks is None or name in self._whole:
            return
        expected = int(np.prod([-(-n // c) for n, c in zip(dataset.shape, dataset.chunks)]))
        if dataset.id.get_num_chunks() != expected:
            raise StudyError(f"{self.path}: /{name} is damaged: chunks are missing.")
        self._whole.add(name)
