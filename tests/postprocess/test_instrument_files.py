# SPDX-License-Identifier: BSD-3-Clause
"""Recordings as instruments write them: the proposal and the import understand them, or name the
line and the remedy. Each has the same swing of 36.56 Hz, sampled at 2000 Hz, released at 0.1 s."""
import datetime
import os
import re
import shutil
import tomllib
import unittest

import h5py
import import_recording
import numpy as np
import scipy.io
from recording_files import RecordingFiles

TRACK = os.environ.get("CULM_TRACK")
RATE, RELEASE, FREQUENCY, DAMPING_RATIO, PULL = 2000.0, 0.1, 36.56, 0.004, 6.0
TIMES = np.arange(1200) / RATE


def swing(times, release=RELEASE):
    after = np.maximum(times - release, 0.0)
    decay = np.exp(-DAMPING_RATIO * 2.0 * np.pi * FREQUENCY * after)
    noise = np.random.default_rng(7).normal(0.0, 0.005, len(times))
    return PULL * decay * np.cos(2.0 * np.pi * FREQUENCY * after) + noise


TIP = swing(TIMES)


def table(header, *columns, separator=",", end=""):
    lines = (separator.join(str(value) for value in row) for row in zip(*columns))
    return header + "\n" + "\n".join(lines) + "\n" + end


def rounded(values, digits=4):
    return [f"{value:.{digits}f}" for value in values]


class InstrumentFiles(RecordingFiles):
    def proposal_of(self, place):
        """Writes and completes the proposal; returns it as it was proposed, and what was printed."""
        output = self.folder / "out"
        code, printed, error = self.ran(import_recording, place, output)
        self.assertEqual((code, error), (0, ""))
        mapping = output / "import.toml"
        return tomllib.loads(mapping.read_text("utf-8")), " ".join(printed.split())

    def refusal_of(self, content, name="log.csv"):
        code, printed, error = self.ran(import_recording, self.file(name, content),
                                        self.folder / "out")
        self.assertEqual((code, printed), (2, ""))
        return " ".join(error.split())

    def imported(self, **values):
        """Completes the proposal and imports; returns stem.toml, the readings and what was printed."""
        place = self.folder / "out" / "import.toml"
        text = place.read_text("utf-8").split("# diameter_mm")[0]
        known = {"height_mm": 140, "length_mm": 140, "density_kg_m3": 2700, "unit": '"mm"', **values}
        for key, value in known.items():
            text = re.sub(rf"(?m)^# {key} =.*$", f"{key} = {value}", text)
        place.write_text(text + '[section]\nshape = "rectangle"\nwidth_mm = 20\nheight_mm = 1\n',
                         "utf-8")
        code, printed, error = self.ran(import_recording, place, self.folder / "out",
                                        "--culm-track", TRACK)
        self.assertEqual(code, 0, error)
        readings = np.genfromtxt(self.folder / "out" / "deflection.csv", delimiter=",",
                                 skip_header=1)
        return readings, " ".join((printed + error).split())

    def assert_swing(self, readings, times=TIMES):
        """The readings are those of the swing, from its release on."""
        self.assertEqual(len(readings), len(times))
        self.assertAlmostEqual(readings[0, 0], times[0] - RELEASE, delta=5e-4)
        seen = np.isfinite(readings[:, 1])
        self.assertLess(np.max(np.abs(readings[seen, 1] - TIP[seen])), 0.1)


@unittest.skipUnless(TRACK, "needs culm-track")
class Clocks(InstrumentFiles):
    def test_a_counter_of_microseconds_returns_to_zero(self):
        stamps = (2**32 - 200_000 + np.arange(len(TIMES)) * 500) % 2**32
        mapping, printed = self.proposal_of(self.file("a.csv", table("micros,tip_mm", stamps,
                                                                     rounded(TIP))))
        self.assertEqual((mapping["time"]["unit"], "repeated_times" in mapping["time"]),
                         ("us", False))
        self.assertIn('"micros" counts to 4294967295 and returns to 0', printed)
        readings, printed = self.imported()
        self.assertIn("2000 samples/s", printed)
        self.assert_swing(readings)

    def test_days_of_a_spreadsheet(self):
        days = [f"{45415.4 + time / 86400:.10f}".replace(".", ",") for time in TIMES]
        readings = [value.replace(".", ",") for value in rounded(TIP)]
        mapping, _ = self.proposal_of(self.file("a.csv", table("Timestamp;Tip [mm]", days, readings,
                                                               separator=";")))
        self.assertEqual(mapping["time"]["unit"], "day")
        self.assert_swing(self.imported()[0])

    def test_packets_of_ten_samples_share_a_stamp(self):
        stamps = rounded(np.floor(TIMES * RATE / 10.0) * 10.0 / RATE)
        mapping, _ = self.proposal_of(self.file("a.csv", table("time_s,tip_mm", stamps,
                                                               rounded(TIP))))
        self.assertEqual(mapping["time"]["repeated_times"], "spread")
        readings, printed = self.imported()
        self.assertRegex(printed, r"all samples are 0\.(5|4999\d*) ms apart")
        self.assertLess(np.max(np.abs(np.diff(readings[:, 0]) - 1.0 / RATE)), 1e-6)

    def test_a_clock_that_was_set_back_is_refused_with_its_line(self):
        stamps = np.where(np.arange(len(TIMES)) < 700, TIMES, TIMES - 0.2)
        refusal = self.refusal_of(table("time_s,tip_mm", rounded(stamps), rounded(TIP)))
        self.assertIn('"time_s" goes back by 0.1995 s (line 702)', refusal)
        self.assertIn("400 rows", refusal)
        self.assertIn("[time] rate_hz", refusal)


    def test_dates_of_three_countries(self):
        start = datetime.datetime(2024, 5, 3, 23, 59, 59, 700_000)  # midnight is in the record
        stamps = [start + datetime.timedelta(seconds=float(time)) for time in TIMES]
        for number, (form, separator) in enumerate((("%d.%m.%Y %H:%M:%S,%f", ";"),
                                                    ("%m/%d/%Y %I:%M:%S.%f %p", ","),
                                                    ("%Y-%m-%dT%H:%M:%S.%fZ", ","))):
            with self.subTest(form):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                mapping, printed = self.proposal_of(self.file(f"{number}.csv", table(
                    f"Date/Time{separator}Tip (mm)", [stamp.strftime(form) for stamp in stamps],
                    rounded(TIP), separator=separator)))
                self.assertEqual(mapping["time"]["column"], "Date/Time")
                self.assert_swing(self.imported()[0])

    def test_a_run_with_other_times_is_not_read_beside_the_first(self):
        place = self.file("a.csv", table(
            "Latest: Time (s),Latest: Position (mm),Run 2: Time (s),Run 2: Position (mm)",
            rounded(TIMES), rounded(TIP), rounded(0.3 + 1.7 * TIMES), rounded(TIP)))
        mapping, printed = self.proposal_of(place)
        self.assertEqual(mapping["height"], [{"columns": "Latest: Position (mm)"}])
        self.assertIn('column "Run 2: Position (mm)" needs another mapping', printed)

    def test_the_times_of_a_table_without_names_are_not_its_counter(self):
        mapping, _ = self.proposal_of(self.file("a.csv", table(
            "0,0.0,6.0", np.arange(1, 1200), rounded(TIMES[1:]), rounded(TIP[1:]))))
        self.assertEqual(mapping["time"]["column"], "2")


@unittest.skipUnless(TRACK, "needs culm-track")
class Instruments(InstrumentFiles):
    def test_labview_with_a_time_column_for_each_channel(self):
        header = ("LabVIEW Measurement\t\nDecimal_Separator\t.\nX_Columns\tMulti\n"
                  "***End_of_Header***\t\n\t\nChannels\t2\t\t\t\nSamples\t1200\t\t1200\t\n"
                  "Y_Unit_Label\tmm\t\tVolts\t\nX_Dimension\tTime\t\tTime\t\n"
                  "X0\t0.0\t\t0.0\t\nDelta_X\t0.0005\t\t0.0005\t\n***End_of_Header***\t\t\t\t\n"
                  "X_Value\tTip\tX_Value\tTrigger\tComment")
        place = self.file("a.lvm", table(header, rounded(TIMES), rounded(TIP), rounded(TIMES),
                                         rounded(5.0 * (TIMES >= RELEASE)), separator="\t"))
        mapping, printed = self.proposal_of(place)
        self.assertEqual((mapping["time"]["column"], mapping["height"]), ("1", [{"columns": "Tip"}]))
        self.assertIn('column 1, "X_Value"', printed)
        self.assert_swing(self.imported()[0])

    def test_labview_without_times_and_with_decimal_commas(self):
        header = ("LabVIEW Measurement\t\nDecimal_Separator\t,\nX_Columns\tNo\n"
                  "***End_of_Header***\t\n\t\nChannels\t1\nSamples\t1200\nY_Unit_Label\tmm\n"
                  "X0\t0,25\nDelta_X\t0,0005\n***End_of_Header***\t\nX_Value\tTip\tComment")
        place = self.file("a.lvm", table(header, [""] * len(TIMES),
                                         [text.replace(".", ",") for text in rounded(TIP)],
                                         separator="\t"))
        mapping, printed = self.proposal_of(place)
        self.assertEqual((mapping["time"]["rate_hz"], mapping["height"]),
                         (2000, [{"columns": "Tip"}]))
        self.assertIn('2000 samples/s: line 10, "Delta_X" ([time] rate_hz)', printed)
        self.assert_swing(self.imported()[0])

    def test_one_column_of_decimal_commas(self):
        place = self.file("a.txt", "Weg (mm)\n" + "\n".join(rounded(TIP)).replace(".", ","))
        mapping, _ = self.proposal_of(place)
        self.assertEqual(mapping["source"]["decimal"], ",")
        self.assert_swing(self.imported(rate_hz=2000)[0])

    def test_quoted_decimal_commas_between_commas(self):
        quoted = [[f'"{text.replace(".", ",")}"' for text in rounded(values)]
                  for values in (TIMES, TIP)]
        mapping, _ = self.proposal_of(self.file("a.csv", table('"Zeit (s)","Weg (mm)"', *quoted)))
        self.assertEqual((mapping["source"]["delimiter"], mapping["source"]["decimal"]), (",", ","))
        self.assert_swing(self.imported()[0])

    def test_an_oscilloscope_states_units_in_a_row_and_volts_need_a_factor(self):
        place = self.file("a.csv", table("Time,Channel A\n(ms),(V)\n", rounded(1e3 * TIMES),
                                         rounded(TIP / 2.5)))
        mapping, printed = self.proposal_of(place)
        self.assertEqual(mapping["time"]["unit"], "ms")
        self.assertIn("factors", printed)
        self.assert_swing(self.imported(factors='{ "Channel A" = 2.5 }')[0])

    def test_volts_without_a_factor_are_noted(self):
        self.proposal_of(self.file("a.csv", table("Time,Channel A\n(ms),(V)\n",
                                                  rounded(1e3 * TIMES), rounded(TIP))))
        self.assertIn('"Channel A" is in V by the file, and in mm by the mapping', self.imported()[1])

    def test_positions_of_a_network_are_gaps_where_they_are_unlikely(self):
        lost = np.arange(len(TIMES)) % 397 < 8
        other = np.arange(len(TIMES)) % 397 > 390
        x = np.where(lost, -40.0, 300.0 + 4.0 * TIP)
        place = self.file("a.csv", table(
            "scorer,DLC,DLC,DLC,DLC,DLC,DLC\nbodyparts,tip,tip,tip,mid,mid,mid\n"
            "coords,x,y,likelihood,x,y,likelihood", np.arange(len(TIMES)), rounded(x), rounded(x),
            np.where(lost, 0.02, 0.97), rounded(x), rounded(x), np.where(other, 0.1, 0.97)))
        mapping, printed = self.proposal_of(place)
        self.assertEqual(mapping["height"][0], {"columns": "tip x"})
        self.assertIn("32 rows with tip likelihood < 0.6 are gaps", printed)
        text = (self.folder / "out" / "import.toml").read_text("utf-8")
        text = re.sub(r"\[\[height\]\]\ncolumns = \"(tip y|mid .)\"\n.*\n\n?", "", text)
        (self.folder / "out" / "import.toml").write_text(text, "utf-8")
        readings, _ = self.imported(fps=RATE, unit='"px"\nmm_per_px = 0.25')
        self.assertEqual(int(np.isnan(readings[:, 1]).sum()), int(lost.sum()))
        self.assert_swing(readings)

    def test_infinite_readings_and_readings_beyond_the_range_are_gaps(self):
        texts = rounded(np.minimum(TIP, 4.0))
        texts[900] = texts[901] = "inf"
        mapping, printed = self.proposal_of(self.file("a.csv", table("time_s,tip_mm",
                                                                     rounded(TIMES), texts)))
        self.assertIn("2 readings are infinite, which is a gap (lines 902–903)", printed)
        # The stem is held beyond the range, so the record begins in motion.
        self.assertEqual(mapping["release"], {"kind": "moving"})
        readings, _ = self.imported()
        self.assertTrue(np.all(np.isnan(readings[:200, 1])))

    def test_columns_of_fixed_width_with_a_footer(self):
        text = "Time (s)  Tip (mm)\n" + "".join(f"{a:10.4f}{b:12.4f}\n" for a, b in zip(TIMES, TIP))
        mapping, printed = self.proposal_of(self.file("a.txt", text + "\nEnd of data\nMax: 6.01 "
                                                                      "Min: -5.9\n"))
        self.assertEqual(mapping["time"]["column"], "Time (s)")
        self.assertIn('2 lines below the first row are not part of the table', printed)
        self.assert_swing(self.imported()[0])

    def test_a_rate_and_a_unit_above_the_table(self):
        place = self.file("a.txt", table("# Sampling rate: 2000 Hz\n# Unit: mm\nSample\tTip",
                                         np.arange(len(TIMES)), rounded(TIP), separator="\t"))
        mapping, _ = self.proposal_of(place)
        self.assertEqual((mapping["camera"]["fps"], mapping["motion"]["unit"]), (2000, "mm"))
        self.assert_swing(self.imported()[0])

    def test_a_counter_beside_numbers_of_three_digits_is_no_group(self):
        place = self.file("a.csv", table("# Range: 1,000.0 mm\nframe,tip_mm", np.arange(len(TIMES)),
                                         rounded(TIP + 150.0)))
        mapping, _ = self.proposal_of(place)
        self.assertEqual((mapping["time"]["column"], mapping["height"]),
                         ("frame", [{"columns": "tip_mm"}]))
        self.assert_swing(self.imported(fps=2000)[0])

    def test_a_date_alone_is_not_the_time(self):
        place = self.file("a.csv", table("Date,Seconds of run,Tip_mm", ["2026-11-20"] * len(TIMES),
                                         rounded(TIMES), rounded(TIP)))
        mapping, _ = self.proposal_of(place)
        self.assertEqual(mapping["time"]["column"], "Seconds of run")

    def test_digits_in_groups_are_refused(self):
        refusal = self.refusal_of(table("time_ms;tip_um", rounded(1e3 * TIMES, 1),
                                        [f"{1e3 * value:,.1f}" for value in TIP], separator=";"))
        self.assertRegex(refusal, r'line 2: the digits of "[56],\d+\.\d" are in groups')


@unittest.skipUnless(TRACK, "needs culm-track")
class Workspaces(InstrumentFiles):
    def matlab(self, **arrays):
        place = self.folder / "a.mat"
        scipy.io.savemat(place, arrays)
        return place

    def test_a_rate_without_times(self):
        mapping, _ = self.proposal_of(self.matlab(fs=RATE, tip=TIP))
        self.assertEqual(mapping["camera"]["fps"], RATE)
        self.assert_swing(self.imported()[0])

    def test_the_first_column_of_a_matrix_is_the_time(self):
        mapping, _ = self.proposal_of(self.matlab(data=np.column_stack([TIMES, TIP])))
        self.assertEqual(mapping["time"]["column"], "data 1")

    def test_hdf5_with_the_ending_of_matlab(self):
        place = self.folder / "a.mat"
        with h5py.File(place, "w", userblock_size=512) as file:
            file["t"], file["tip"] = TIMES[None], TIP[None]
        mapping, _ = self.proposal_of(place)
        self.assertEqual(mapping["time"]["column"], "t")
        self.assert_swing(self.imported()[0])


if __name__ == "__main__":
    unittest.main()
