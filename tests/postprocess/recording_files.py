# SPDX-License-Identifier: BSD-3-Clause
"""A folder with recordings, and programs that run on them; shared by the tests of `culm import`."""
import contextlib
import io
import tempfile
import unittest
from pathlib import Path


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
    def ran(program, source, output):
        """Exit code, output and errors of a program's main."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = program.main([str(source), "--output", str(output)])
        return code, out.getvalue(), err.getvalue()
