# SPDX-License-Identifier: BSD-3-Clause
"""Folders of results for the tests of the report, and a parser for the content of a page."""
import base64
import json
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import synthetic_results
from synthetic_study import Synthetic

NASTY = "<script>window.injected = 1</script><b onmouseover='window.injected = 2'>&amp;"


class NastyStudy(Synthetic):
    """A study whose name is an attack."""

    def provenance(self):
        return {"compiler": "GNU 12.2", "study_name": NASTY}


def write_everything(folder: Path) -> Path:
    """Writes a study, a calibration, a comparison and a diagnosis, each into a separate folder."""
    for name in ("study", "calibration", "comparison", "diagnosis"):
        (folder / name).mkdir(parents=True)
    NastyStudy().write(folder / "study")
    synthetic_results.write_calibration(folder / "calibration", ("S1", NASTY))
    synthetic_results.write_comparison(folder / "comparison")
    synthetic_results.write(folder / "diagnosis", "diagnosis.json",
                            synthetic_results.diagnosis(NASTY, "unknown"))
    return folder


def unpacked(packed: dict) -> np.ndarray:
    """The numbers that the page packs into 16 bits; NaN for its code of a missing number."""
    values = np.frombuffer(base64.b64decode(packed["values"]), "<i2").astype(float)
    return np.where(values == -32768, np.nan, values * packed["scale"])


class Page(HTMLParser):
    """Elements, ids, texts and data of a page."""

    def __init__(self, text: str):
        super().__init__(convert_charrefs=True)
        self.text, self.tags, self.ids, self.open = text, [], [], []
        self.words, self.data = [], []  # texts; (class, content) of JSON scripts
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append((tag, attributes))
        self.open.append((tag, attributes))
        if "id" in attributes:
            self.ids.append(attributes["id"])

    def handle_endtag(self, tag):
        while self.open and self.open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        tag, attributes = self.open[-1] if self.open else ("", {})
        if tag == "script" and attributes.get("type") == "application/json":
            self.data.append((attributes["class"], json.loads(data)))
        elif tag not in ("script", "style"):
            self.words.append(data)

    def of_class(self, name: str) -> list[dict]:
        return [content for kind, content in self.data if kind == name]

    def drawings(self) -> dict[str, dict]:
        """Data and layout of every drawing by its id."""
        ids = [attributes["id"] for tag, attributes in self.tags
               if attributes.get("class") == "drawing"]
        return dict(zip(ids, self.of_class("plot-data"), strict=True))

    def said(self) -> str:
        return " ".join(" ".join(self.words).split())
