# SPDX-License-Identifier: BSD-3-Clause
"""Decodes a text file: UTF-8, UTF-16 and CP1252, which instruments and spreadsheets write."""
from __future__ import annotations

from pathlib import Path

from recording.refusal import Refusal

MOST_BYTES = 1 << 30
ENCODINGS = ("utf-8", "utf-16", "cp1252", "latin-1")


def utf16_without_mark(content: bytes) -> str | None:
    """The byte order of UTF-16 without a mark: every second byte of a Western text is 0."""
    probe = content[:4096]
    half = len(probe) // 2
    if half < 8:
        return None
    if probe[1::2].count(0) > 0.9 * half and probe[0::2].count(0) == 0:
        return "utf-16-le"
    if probe[0::2].count(0) > 0.9 * half and probe[1::2].count(0) == 0:
        return "utf-16-be"
    return None


def encoding_of(content: bytes) -> str:
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if (found := utf16_without_mark(content)) is not None:
        return found
    if b"\0" in content:
        raise Refusal("it is not a text file; a table of text, .trk, .c3d, .mat, .npy and .npz are "
                      "read")
    try:
        content.decode("utf-8-sig")
        return "utf-8-sig"
    except UnicodeDecodeError:
        return "cp1252"


def decoded_text(file: Path, encoding: str | None = None) -> tuple[str, str]:
    """The text of a file and the encoding that was used; `encoding` replaces the guess."""
    if file.stat().st_size > MOST_BYTES:
        raise Refusal("it is larger than 1 GiB; export a shorter part of the recording")
    content = file.read_bytes()
    if content.startswith(b"PK\x03\x04"):
        raise Refusal("it is a workbook or an archive; save the sheet as CSV")
    if content.startswith(b"\xd0\xcf\x11\xe0"):
        raise Refusal("it is a workbook of an old version; save the sheet as CSV")
    if content.startswith(b"TDSm"):
        raise Refusal("it is LabVIEW's binary TDMS; export it as text (.lvm or CSV)")
    if not content.strip():
        raise Refusal("the file is empty")
    used = encoding or encoding_of(content)
    used = "utf-8-sig" if used == "utf-8" else used
    try:
        return content.decode(used), used.removesuffix("-sig")
    except UnicodeDecodeError as error:
        if used == "cp1252" and encoding is None:  # five bytes are not in it
            return content.decode("latin-1"), "latin-1"
        raise Refusal(f"byte {error.start + 1} is not {used}; [source] encoding may be "
                      f"{', '.join(ENCODINGS)}") from None
