# SPDX-License-Identifier: BSD-3-Clause
"""Tables of foreign recordings contain every value of the recording, at its time."""
import math
import pickle
import unittest
import zipfile
from pathlib import Path

import numpy as np
from recording.recorded_file import recorded_table
from recording.text_table import TextOptions
from recording_files import RecordingFiles

EXAMPLE = Path(__file__).resolve().parents[1] / "data/recordings/tracker.trk"
MEDIA, TRACKER = "org.opensourcephysics.media.core.", "org.opensourcephysics.cabrillo.tracker."


def properties(**values):
    return "".join(f'<property name="{name}" type="double">{value}</property>'
                   for name, value in values.items())


def framedata(**frames):
    """An array of the objects of the frames, named f0, f1, …"""
    places = "".join(f'<property name="[{name[1:]}]" type="object"><object>{properties(**values)}'
                     "</object></property>" for name, values in frames.items())
    return f'<property name="framedata" type="array">{places}</property>'


def thing(name, kind, content):
    return (f'<property name="{name}" type="object"><object class="{kind}">{content}</object>'
            "</property>")


def point(name, **frames):
    return thing("item", TRACKER + "PointMass",
                 f'<property name="name" type="string">{name}</property>{framedata(**frames)}')


def axes(xorigin=100.0, yorigin=200.0, angle=0.0, xscale=10.0, yscale=10.0):
    return {"xorigin": xorigin, "yorigin": yorigin, "angle": angle, "xscale": xscale,
            "yscale": yscale}


def project(*points, clip="", control=properties(delta_t=100.0), coords=None):
    return (f'<object class="{TRACKER}TrackerPanel">'
            + thing("videoclip", MEDIA + "VideoClip", clip)
            + thing("clipcontrol", MEDIA + "StepperClipControl", control)
            + thing("coords", MEDIA + "ImageCoordSystem", framedata(**(coords or {"f0": axes()})))
            + f'<property name="tracks" type="collection">{"".join(points)}</property></object>')


class TrackerProjects(RecordingFiles):
    def tracked(self, *points, **settings):
        return self.table(self.file("video.trk", project(*points, **settings)))

    def refused(self, *points, **settings):
        return self.refused_table(self.file("video.trk", project(*points, **settings)))

    def test_the_zip_file_of_a_project_is_read(self):
        place = self.folder / "video.trz"
        with zipfile.ZipFile(place, "w") as archive:
            archive.write(EXAMPLE, "swing.trk")
            archive.writestr("videos/swing.mp4", b"film")
        self.assertEqual(self.table(place), self.table(EXAMPLE))
        with zipfile.ZipFile(place, "a") as archive:
            archive.write(EXAMPLE, "other.trk")
        self.assertIn("2 projects (swing.trk, other.trk)", self.refused_table(place))
        place.write_bytes(place.read_bytes()[:-40])
        self.assertIn("not a whole zip file", self.refused_table(place))

    def test_example_swings_as_it_was_made(self):
        table = self.table(EXAMPLE)
        self.assertEqual(list(table), ["t", "tip x", "tip y", "clamp x", "clamp y"])
        self.assertEqual(len(table["t"]), 40)
        for n, t in enumerate(table["t"]):
            self.assertAlmostEqual(t, n / 120.0, places=14)
            free = max(0, n - 8) / 120.0
            swing = 0.02 * math.exp(-2.0 * free) * math.cos(10.0 * math.pi * free)
            # The file has pixels rounded to 0.001, of which 2000 are 1 m.
            self.assertAlmostEqual(table["tip x"][n], swing, delta=3e-7)
            self.assertAlmostEqual(table["tip y"][n], 0.15, delta=3e-7)
        self.assertEqual(set(table["clamp x"] + table["clamp y"]), {0.0})

    def test_frames_count_from_the_clip_and_gaps_are_empty(self):
        clip = properties(startframe=4, stepsize=2, stepcount=4, starttime=500.0)
        table = self.tracked(point("a", f2={"x": 0, "y": 0}, f4={"x": 110, "y": 180},
                                   f10={"x": 130, "y": 170}),
                             point("b", f8={"x": 90, "y": 210}), clip=clip)
        self.assertEqual(table, {"t": [0.5, 0.7, 0.9, 1.1], "a x": [1.0, None, None, 3.0],
                                 "a y": [2.0, None, None, 3.0], "b x": [None, None, -1.0, None],
                                 "b y": [None, None, -1.0, None]})

    def test_turned_axes(self):
        # Axes turned by 90° against the clock: their x points up in the picture, their y left.
        table = self.tracked(point("a", f0={"x": 100, "y": 180}, f1={"x": 70, "y": 200}),
                             coords={"f0": axes(angle=90.0)})
        np.testing.assert_allclose(table["a x"], [2.0, 0.0], atol=1e-15)
        np.testing.assert_allclose(table["a y"], [0.0, 3.0], atol=1e-15)

    def test_moving_axes_hold_from_their_frame_on(self):
        place = {"x": 120, "y": 180}
        table = self.tracked(
            point("a", f0=place, f1=place, f2=place, f3=place),
            coords={"f0": axes(), "f2": axes(xorigin=110.0, xscale=5.0, yscale=20.0)})
        self.assertEqual(table["a x"], [2.0, 2.0, 2.0, 2.0])
        self.assertEqual(table["a y"], [2.0, 2.0, 1.0, 1.0])

    def test_frame_time_of_the_video_where_the_control_has_none(self):
        clip = thing("video", MEDIA + "ImageVideo", properties(delta_t=4.0))
        table = self.tracked(point("a", f0={"x": 0, "y": 0}, f1={"x": 0, "y": 0}), clip=clip,
                             control="")
        self.assertEqual(table["t"], [0.0, 0.004])

    def test_unequal_frames_have_the_times_of_the_video(self):
        times = ('<property name="start_times" type="array" class="[D"><property name="array" '
                 'type="string">{0.0,10.0,40.0,60.0}</property></property>')
        table = self.tracked(*[point("a", **{f"f{n}": {"x": 0, "y": 0} for n in range(1, 4)})],
                             clip=properties(startframe=1) + thing("video", "MovieVideo", times),
                             control=properties(delta_t=40.0))  # stretched from 20 ms
        np.testing.assert_allclose(table["t"], [0.0, 0.06, 0.1], rtol=1e-15)

    def test_refuses_what_is_no_project(self):
        self.assertIn("not XML", self.refused_table(self.file("video.trk", "frame 1 2")))
        self.assertIn("not XML", self.refused_table(self.file("video.trk", b"\x00\xff\x01")))
        self.assertIn("not a project", self.refused_table(self.file("video.trk", "<object/>")))
        text = project(point("&x;", f0={"x": 0, "y": 0}))
        for before in ('<!DOCTYPE object [<!ENTITY x "y">]>', "<!DOCTYPE object>"):
            self.assertIn("document type", self.refused_table(self.file("video.trk", before + text)))

    def test_refuses_projects_without_a_usable_position(self):
        here = {"x": 0, "y": 0}
        self.assertIn("track one point", self.refused())
        self.assertIn("track one point", self.refused(point("a")))
        self.assertIn("'a x'", self.refused(point("a", f0=here), point("a", f0=here)))
        self.assertIn("'y'", self.refused(point("a", f0={"x": 1})))
        self.assertIn("scales above 0", self.refused(point("a", f0=here),
                                                     coords={"f0": axes(xscale=0.0)}))
        self.assertIn("abc", self.refused(point("a", f0={"x": "abc", "y": 0})))
        self.assertIn("inf", self.refused(point("a", f0={"x": "1e400", "y": 0})))
        self.assertIn("frames from [0]", self.refused(point("a", fn=here)))
        self.assertIn("delta_t", self.refused(point("a", f0=here), control=""))
        self.assertIn("above 0", self.refused(point("a", f0=here), control=properties(delta_t=0)))
        self.assertIn("stepsize", self.refused(point("a", f0=here), clip=properties(stepsize=0)))


class MatlabFiles(RecordingFiles):
    def saved(self, **variables):
        from scipy.io import savemat
        place = self.folder / "record.mat"
        savemat(place, variables, do_compression=True)
        return place

    def test_arrays_and_fields_of_the_common_length_are_columns(self):
        table = self.table(self.saved(
            tip=[0.1, np.nan, 1.0 / 3.0], run={"time": [0.0, 0.5, 1.0], "rate": 2.0},
            sensors=np.arange(6.0).reshape(2, 3), note="steel", offsets=[1.0, 2.0]))
        self.assertEqual(table, {"run.time": [0.0, 0.5, 1.0], "tip": [0.1, None, 1.0 / 3.0],
                                 "sensors 1": [0.0, 1.0, 2.0], "sensors 2": [3.0, 4.0, 5.0]})
        self.assertEqual(next(iter(table)), "run.time")

    def test_frames_are_counted_without_a_time(self):
        table = self.table(self.saved(x=np.array([[7], [8]], np.int16)))
        self.assertEqual(table, {"frame": [0, 1], "x": [7, 8]})

    def test_refuses_files_without_an_array_and_lists_what_they_have(self):
        sentence = self.refused_table(self.saved(note="steel", image=np.zeros((3, 4, 5))))
        self.assertIn("note (str", sentence)
        self.assertIn("image (float64, shape (3, 4, 5))", sentence)

    def test_reads_version_7_3(self):
        import h5py
        place = self.folder / "record.mat"
        with h5py.File(place, "w", userblock_size=512) as file:
            file["t"], file["run/tip"] = np.array([[0.0], [0.5], [1.0]]), np.array([[1.0, 2.0, 3.0]])
        with place.open("r+b") as stream:
            stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
        self.assertEqual(self.table(place), {"t": [0.0, 0.5, 1.0], "run.tip": [1.0, 2.0, 3.0]})

    def test_of_a_workspace_takes_the_arrays_that_go_with_the_time(self):
        place = self.saved(t=np.arange(4) / 2, tip=np.arange(4.0), f=np.arange(3.0), psd=np.ones(3),
                           phase=np.zeros(3), fs=2.0)
        self.assertEqual(list(self.table(place)), ["t", "tip"])
        self.assertEqual(list(self.table(place, "f")), ["frame", "f", "psd", "phase"])
        table = recorded_table(place, TextOptions(), [])
        self.assertIn("f, psd, phase (3 values)", str(table.assumptions[0]))
        self.assertEqual(table.rate.hertz, 2.0)

    def test_refuses_damaged_files(self):
        header = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
        self.assertIn("7.3", self.refused_table(self.file("record.mat", header + b"\x89HDF\r\n")))
        for content in (b"", b"text", self.saved(x=np.random.rand(99)).read_bytes()[:300]):
            self.assertIn("not a whole", self.refused_table(self.file("record.mat", content)))


class NumpyFiles(RecordingFiles):
    def saved(self, array):
        np.save(self.folder / "record.npy", array)
        return self.folder / "record.npy"

    def test_displacements_of_points_are_rows_then_columns_of_the_picture(self):
        moved = np.random.default_rng(1).normal(size=(2, 5, 2))
        table = self.table(self.saved(moved))
        self.assertEqual(list(table),
                         ["frame", "point 1 y", "point 1 x", "point 2 y", "point 2 x"])
        self.assertEqual(table["frame"], [0, 1, 2, 3, 4])
        for p in (0, 1):
            self.assertEqual(table[f"point {p + 1} y"], moved[p, :, 0].tolist())
            self.assertEqual(table[f"point {p + 1} x"], moved[p, :, 1].tolist())

    def test_frames_are_the_long_side_of_a_matrix(self):
        values = np.array([[0.1, 0.2, np.nan], [4, 5, 6]], np.float32)
        expected = {"frame": [0, 1, 2], "1": [*values[0, :2].tolist(), None], "2": [4, 5, 6]}
        self.assertEqual(self.table(self.saved(values)), expected)
        self.assertEqual(self.table(self.saved(values.T)), expected)
        self.assertEqual(self.table(self.saved(values[1])), {"frame": [0, 1, 2], "1": [4, 5, 6]})

    def test_named_arrays(self):
        place = self.folder / "record.npz"
        np.savez(place, tip=[0.5, 0.25], T=[3.0, 4.0], rate=120.0)
        self.assertEqual(self.table(place), {"T": [3.0, 4.0], "tip": [0.5, 0.25]})

    def test_refuses_other_contents(self):
        self.assertIn("(points, frames, 2)", self.refused_table(self.saved(np.zeros((2, 3, 4)))))
        self.assertIn("(points, frames, 2)", self.refused_table(self.saved(np.zeros((2, 0, 2)))))
        self.assertIn("one or two", self.refused_table(self.saved(np.array(["a", "b"]))))
        self.assertIn("pickle", self.refused_table(self.saved(np.array([None]))))
        for content in (b"", b"PK\x03\x04", pickle.dumps([1.0]), b"\x93NUMPY\x01\x00\x10\x00{}"):
            self.assertIn("not a whole", self.refused_table(self.file("record.npy", content)))

    def test_refuses_other_names_and_missing_files(self):
        self.assertIn("numpy.save as .npy", self.refused_table(self.file("results.pkl", b"")))
        for name in ("none.trk", "none.mat", "none.npy", "none.csv"):
            with self.assertRaises(FileNotFoundError):
                self.table(self.folder / name)


if __name__ == "__main__":
    unittest.main()
