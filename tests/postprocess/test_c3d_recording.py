# SPDX-License-Identifier: BSD-3-Clause
"""Tables of C3D files contain every position of every marker, in metres."""
from __future__ import annotations

import math
import time
import unittest
from array import array

from c3d_example import C3dExample, group, parameter, padded, real, texts, word
from recording.refusal import Refusal
from recording_files import RecordingFiles

NAMES = ["t", "base x", "base y", "base z", "tip x", "tip y", "tip z"]


class C3dFiles(RecordingFiles):
    def rows(self, content: bytes, name: str = "a.c3d") -> list[list[str]]:
        """The names, and the cells of each frame; an empty cell is a gap."""
        table = self.table(self.file(name, content))
        cells = [["" if value is None else repr(value) for value in values]
                 for values in table.values()]
        return [list(table), *map(list, zip(*cells))]

    def refusal(self, content: bytes) -> str:
        reason = self.refused_table(self.file("a.c3d", content))
        start = "not a C3D file that can be read: "
        self.assertTrue(reason.startswith(start), reason)
        return reason.removeprefix(start)

    def header_of(self, **settings) -> list[str]:
        return self.rows(C3dExample(**settings).content())[0]


class Values(C3dFiles):
    def test_every_number_format(self):
        for is_real in (True, False):
            for analog in (0, 5):
                example = C3dExample(is_real=is_real, analog_words=analog)
                expected = [[repr(i / 200.0)] + [repr(1e-3 * value) for value in
                                                 example.positions[6 * i:6 * i + 6]]
                            for i in range(3)]
                with self.subTest(is_real=is_real, analog=analog):
                    self.assertEqual(self.rows(example.content()), [NAMES, *expected])

    def test_letter_case_of_the_name(self):
        content = C3dExample().content()
        self.assertEqual(self.rows(content, "a.C3D"), self.rows(content))

    def test_units_of_length(self):
        for unit, metres in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)):
            rows = self.rows(C3dExample(unit=unit).content())[1:]
            self.assertEqual([float(cell) for row in rows for cell in row[1:]],
                             [metres * value for value in C3dExample().positions])
        for unit in ("in", "MM", ""):
            self.assertEqual(self.refusal(C3dExample(unit=unit).content()),
                             f'POINT:UNITS = "{unit}": must be mm, cm or m')
        self.assertEqual(self.refusal(C3dExample(unit=None).content()),
                         'POINT:UNITS = "": must be mm, cm or m')

    def test_gaps_where_a_marker_is_not_seen(self):
        for is_real, residual in ((True, -1.0), (True, math.nan), (False, -1.0)):
            rows = self.rows(C3dExample(is_real=is_real,
                                        residuals=[0, 0, 2, residual, 0, 0]).content())
            cells = [cell for row in rows[1:] for cell in row[1:]]
            self.assertEqual(cells, ["" if 9 <= i < 12 else repr(1e-3 * value)
                                     for i, value in enumerate(C3dExample().positions)])

    def test_a_coordinate_that_is_no_number_is_a_gap(self):
        example = C3dExample()
        example.positions[4] = math.nan
        self.assertEqual(self.rows(example.content())[1][5], "")


class Labels(C3dFiles):
    def test_several_parameters_of_labels(self):
        parts = texts("LABELS", ["base"]) + texts("LABELS2", ["tip"])
        self.assertEqual(self.header_of(labels_parameter=parts), NAMES)

    def test_markers_without_a_label_or_with_a_repeated_one_are_numbered(self):
        for labels, second in ((["base"], "marker 2"), (["base", ""], "marker 2"),
                               (["base", "base"], "marker 2"), (["base", b"t\0i\n"], "t?i?"),
                               (["base", b"\xb5m"], "µm"), (["base", "µm"], "µm")):
            header = self.header_of(labels_parameter=texts("LABELS", labels))
            self.assertEqual(header, NAMES[:4] + [f"{second} {axis}" for axis in "xyz"])
        self.assertIn("must differ", self.refusal(C3dExample(
            labels_parameter=texts("LABELS", ["marker 2", "marker 2"])).content()))

    def test_labels_of_the_example_in_lower_case_entries(self):
        lower = texts("labels", ["base", "tip"]).replace(b"LABELS", b"labels")
        self.assertEqual(self.header_of(labels_parameter=lower), NAMES)


class FrameCounts(C3dFiles):
    def count(self, more: bytes, frames: int = 70000, last: int = 65535) -> int:
        example = C3dExample(is_real=False, labels=["tip"], frames=frames, more=more,
                             last_frame=last, positions=[1.0, 2.0, 3.0] * frames)
        rows = self.rows(example.content())
        self.assertEqual(rows[-1], [repr((len(rows) - 2) / 200.0), "0.001", "0.002", "0.003"])
        return len(rows) - 1

    def test_more_frames_than_the_header_can_count(self):
        def field(name: str, low: int, high: int) -> bytes:
            return parameter(name, 2, [2], word(low) + word(high), number=2)
        trial = (group(2, "TRIAL") + field("ACTUAL_START_FIELD", 1, 0)
                 + field("ACTUAL_END_FIELD", 70000 - 65536, 1))
        self.assertEqual(self.count(b""), 65535)
        self.assertEqual(self.count(parameter("LONG_FRAMES", 4, [], real(70000.0))), 70000)
        self.assertEqual(self.count(parameter("FRAMES", 4, [], real(69999.0))), 69999)
        self.assertEqual(self.count(trial), 70000)
        self.assertEqual(self.count(trial, frames=40, last=40), 40)

    def test_number_of_frames_is_bounded_by_the_file(self):
        frames = parameter("LONG_FRAMES", 4, [], real(1e9))
        self.assertEqual(self.refusal(C3dExample(more=frames).content()),
                         f"1000000000 frames of 2 markers need {1024 + 32 * 10**9} bytes, the file "
                         "has 1536")
        frames = parameter("LONG_FRAMES", 4, [], real(math.inf))
        self.assertEqual(self.refusal(C3dExample(more=frames).content()),
                         "POINT:LONG_FRAMES = inf: must be a whole number from 1 to 1000000000")
        self.assertEqual(self.refusal(C3dExample(last_frame=0).content()), "it holds no markers")

    def test_a_long_recording_is_read_within_seconds(self):
        values = array("f", range(120)) * 20000
        example = C3dExample(labels=[f"m{k}" for k in range(30)], frames=20000)
        example.data = values.tobytes
        started = time.process_time()
        rows = self.rows(example.content())
        self.assertEqual(len(rows), 20001)
        self.assertEqual(rows[-1][-3:], [repr(1e-3 * value) for value in (116.0, 117.0, 118.0)])
        self.assertLess(time.process_time() - started, 30.0)


class Refusals(C3dFiles):
    def test_other_formats_and_truncated_files(self):
        whole = C3dExample().content()
        for content in (b"", b"time,x\n", b"\x01" + whole[1:]):
            self.assertIn("its first two bytes", self.refusal(content))
        self.assertIn("it ends after 600 bytes, data was expected at byte ",
                      self.refusal(whole[:600]))
        self.assertEqual(self.refusal(whole[:1100]),
                         "3 frames of 2 markers need 1120 bytes, the file has 1100")
        for processor in (85, 86, 80):  # DEC, MIPS
            other = whole[:515] + bytes([processor]) + whole[516:]
            self.assertEqual(self.refusal(other), f"processor type {processor}; only files of "
                                                  "type 84 (Intel) are read")
        self.assertIn("has the type 3: must be -1 (text), 1 (byte), 2 (integer) or 4 (real)",
                      self.refusal(C3dExample(more=parameter("ODD", 3, [], b"abc")).content()))

    def test_damaged_bytes_lead_to_a_result_or_a_refusal(self):
        whole = C3dExample().content()
        for at in range(1120):
            damaged = bytearray(whole)
            damaged[at] ^= 0xFF
            try:
                self.table(self.file("a.c3d", bytes(damaged)))
            except Refusal as reason:
                self.assertGreater(len(str(reason)), 10, at)
        for length in range(0, 1120, 7):
            self.refusal(whole[:length])

    def test_number_of_markers_is_bounded_by_the_format_and_the_file(self):
        # An overflow once turned 2^63 markers into frames of 0 bytes and 2^63 iterations.
        for used, shown in ((2.0**63, "9.223372036854776e+18"), (2.0**61, "2.305843009213694e+18"),
                            (-1.0, "-1"), (2.5, "2.5"), (65536.0, "65536"), (math.nan, "nan"),
                            (math.inf, "inf")):
            self.assertEqual(self.refusal(C3dExample(used=used).content()),
                             f"POINT:USED = {shown}: must be a whole number from 1 to 65535")
        self.assertIn("3 frames of 65535 markers need",
                      self.refusal(C3dExample(used=65535.0).content()))
        self.assertEqual(self.refusal(C3dExample(used=0.0).content()), "it holds no markers")
        self.assertEqual(self.rows(C3dExample(used=2.0).content()),
                         self.rows(C3dExample().content()))

    def test_a_parameter_must_end_before_the_next_one(self):
        # Every byte begins a parameter of 255 x 255 bytes, each inside the one before.
        content = (padded(C3dExample().header()) + b"\x01\x50\x01\x54"
                   + b"\x01\x01A\x06\x00\x01\x02\xff\xff" * 200 + bytes(1 << 17))
        self.assertEqual(self.refusal(content), "parameter A at byte 516 = 255 x 255 elements of 1 "
                                                "bytes: its entry ends after 0 bytes")

    def test_rate_and_scale_must_be_finite(self):
        for rate, shown in ((math.inf, "inf"), (math.nan, "nan"), (0.0, "0"), (-5.0, "-5")):
            self.assertIn(f"POINT:RATE = {shown}: must be the number of frames per second",
                          self.refusal(C3dExample(rate=rate).content()))
        self.assertEqual(self.refusal(C3dExample(scale=math.nan).content()),
                         "POINT:SCALE = nan: must be a number")

    def test_files_that_never_end_are_refused(self):
        (self.folder / "zero.c3d").symlink_to("/dev/zero")
        self.assertIn("first two bytes", self.refused_table(self.folder / "zero.c3d"))


if __name__ == "__main__":
    unittest.main()
