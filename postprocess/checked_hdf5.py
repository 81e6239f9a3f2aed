# SPDX-License-Identifier: BSD-3-Clause
"""Reading a study file (docs/archive-format.md) so that damage is an error and never a number."""
from __future__ import annotations

import re
import zlib
from pathlib import Path

import h5py
import numpy as np

FORMAT_NAME = "culm-study"
FORMAT_MAJOR = 1


class StudyError(Exception):
    """A result folder cannot be read or does not hold what was asked for; one sentence."""


def sentence(error: Exception) -> str:
    """An error of a library as the end of a sentence."""
    lines = str(error).strip().splitlines() or [type(error).__name__]
    return lines[0].rstrip(".") + "."


class CheckedFile:
    """An open study file. Every failure is a StudyError that names the file and the object.

    The checksums of the chunks are HDF5's business; here are the checks that it does not make: the
    format, chunks that are absent (HDF5 would read them as fill values), and the CRC-32 of texts.
    """

    def __init__(self, path: Path):
        self.path = path
        self._whole: set[str] = set()
        try:
            self.file = h5py.File(path, "r")
        except OSError as error:
            hint = " (see HDF5_USE_FILE_LOCKING in docs/archive-format.md)"
            hint = hint if "lock" in str(error) else ""
            text = f"{path} is not a readable HDF5 file{hint}: {sentence(error)}"
            raise StudyError(text) from error
        try:
            self._check_format()
        except BaseException:
            self.file.close()
            raise

    def __contains__(self, name: str) -> bool:
        return name in self.file

    def attribute(self, item: str, name: str):
        try:
            return self.file[item].attrs[name]
        except KeyError:
            raise StudyError(f"{self.path}: {item} lacks the attribute '{name}'.") from None

    def text_list(self, group: str, attribute: str) -> list[str]:
        """An attribute that lists names; empty if the group does not have it."""
        if group not in self.file:
            raise StudyError(f"{self.path}: the group /{group} is missing.")
        return [str(text) for text in self.file[group].attrs.get(attribute, [])]

    def dataset(self, name: str) -> h5py.Dataset:
        item = self.file.get(name)
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

    def text(self, name: str) -> str:
        """A scalar text, compared with its CRC-32: HDF5 has no checksum for it."""
        text = str(self.read(name))
        if zlib.crc32(text.encode("utf-8")) != int(self.attribute(name, "crc32")):
            raise StudyError(f"{self.path}: /{name} is damaged: its checksum is wrong.")
        return text

    def _check_format(self):
        name = self.file.attrs.get("format")
        if name != FORMAT_NAME:
            found = "no format" if name is None else f"the format '{name}'"
            raise StudyError(
                f"{self.path} is not a study archive: it states {found}, not '{FORMAT_NAME}'."
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
