# SPDX-License-Identifier: BSD-3-Clause
"""A folder with recordings, and programs that run on them; shared by the tests of `culm import`."""
import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import numpy as np

from recording.recorded_file import recorded_table
from recording.refusal import Refusal
from recording.text_table import TextOptions


class RecordingFiles(unittest.TestCase):
    """Every test works in an empty folder, `self.folder`."""

    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)

    def file(self, name, content):
        place = self.folder / name
        place.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        return place

    @staticmethod
    def ran(program, source, output, *more):
        """Exit code, output and errors of a program's main."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = program.main([str(source), "--output", str(output), *more])
        return code, out.getvalue(), err.getvalue()

    def table(self, source, *wanted):
        """The columns of a recording in order; a gap is None."""
        table = recorded_table(Path(source), TextOptions(), list(wanted))
        return {name: [None if np.isnan(v) else v for v in table.values(k).tolist()]
                for k, name in enumerate(table.names)}

    def refused_table(self, source):
        """Why a recording is no table."""
        with self.assertRaises(Refusal) as refusal:
            recorded_table(Path(source), TextOptions(), [])
        return str(refusal.exception)
