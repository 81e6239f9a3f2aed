# SPDX-License-Identifier: BSD-3-Clause
"""Damage is found and reported, reading changes nothing, and a folder has one study and one job."""

import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from xml.etree import ElementTree

import h5py

from fault_study import (BAD_INPUT, DONE, MAGIC, PATIENCE, POINTS_FAILED, STOPPED_EARLY, STUDY,
                         LONG_STUDY, committed_points, culm, journal_bytes, start, verify)
from kill_study import contents

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "postprocess"))
from culm.archive import Study, StudyError  # noqa: E402

POINTS = 96  # of the long study


def stored_ranges(archive: Path) -> dict[str, list[tuple[int, int]]]:
    """Offsets and sizes in the file of the stored parts of each dataset."""
    found = {}

    def take(name, item):
        if not isinstance(item, h5py.Dataset):
            return
        if item.chunks is None:
            found[name] = [(item.id.get_offset(), item.id.get_storage_size())]
        else:
            infos = [item.id.get_chunk_info(k) for k in range(item.id.get_num_chunks())]
            found[name] = [(info.byte_offset, info.size) for info in infos]

    with h5py.File(archive, "r") as file:
        file.visititems(take)
    return found


class FaultTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        place = tempfile.TemporaryDirectory(prefix="culm-faults-")
        cls.addClassCleanup(place.cleanup)
        cls.folder = Path(place.name)
        for study, text, output in (("s.toml", STUDY, "whole"),
                                    ("long.toml", LONG_STUDY, "long-whole")):
            (cls.folder / study).write_text(text, encoding="utf-8")
            finished = culm(cls.folder, "run", study, "-o", output, "-q")
            if finished.returncode != DONE:
                raise RuntimeError(finished.stderr)

    def fresh(self, name: str) -> Path:
        """Copies the whole study to this name; returns its archive."""
        shutil.rmtree(self.folder / name, ignore_errors=True)
        shutil.copytree(self.folder / "whole", self.folder / name)
        return self.folder / name / "study.h5"

    def killed(self, name: str) -> Path:
        """Kills the only process of a study after some points; returns its journal."""
        shutil.rmtree(self.folder / name, ignore_errors=True)
        process = self.stopped(name)
        process.kill()
        process.wait()
        return self.folder / name / "journal" / "rank-00000.culmj"

    def stopped(self, name: str):
        """A process that is stopped after it has committed some points."""
        process = start(self.folder, "run", "long.toml", "-o", name, "-q", ranks=1)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        journal = self.folder / name / "journal" / "rank-00000.culmj"
        deadline = time.monotonic() + PATIENCE
        while journal_bytes(self.folder / name) < 40_000:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.001)
        process.send_signal(signal.SIGSTOP)
        self.assertFalse((self.folder / name / "study.h5").exists())
        return process


class Archive(FaultTest):
    def test_flipped_bits_are_found_in_every_dataset_and_only_there(self):
        archive = self.fresh("flipped")
        content = archive.read_bytes()
        chance = random.Random(11)
        ranges = stored_ranges(archive)
        self.assertGreater(len(ranges), 20)
        for dataset, places in ranges.items():
            offset, size = chance.choice(places)
            flipped = bytearray(content)
            flipped[offset + chance.randrange(size)] ^= 1 << chance.randrange(8)
            archive.write_bytes(flipped)
            found = verify(self.folder, "flipped")
            self.assertEqual(found["exit_code"], POINTS_FAILED, dataset)
            damaged = found["archive"]["damaged"]
            if dataset.startswith("provenance/"):  # read on opening; verify names the dataset
                self.assertTrue(found["problems"] or damaged, dataset)
            # A trajectory shares its times with the others, under as many names.
            names = {entry["dataset"].rsplit("/", 1)[-1] for entry in damaged}
            self.assertEqual(names, {dataset.rsplit("/", 1)[-1]}, dataset)

    def test_flipped_bits_between_the_data_never_crash_the_reader(self):
        # Superblock, object headers, links, indices: HDF5's own checksums are over most of it.
        archive = self.fresh("between")
        content = archive.read_bytes()
        data = bytearray(len(content))
        for places in stored_ranges(archive).values():
            for offset, size in places:
                data[offset:offset + size] = b"\x01" * size
        between = [place for place, is_data in enumerate(data) if not is_data]
        chance = random.Random(12)
        found = 0
        for place in chance.sample(between, 150):
            flipped = bytearray(content)
            flipped[place] ^= 1 << chance.randrange(8)
            archive.write_bytes(flipped)
            looked = culm(self.folder, "archive", "verify", "between")
            self.assertIn(looked.returncode, (DONE, BAD_INPUT, POINTS_FAILED),
                          f"byte {place}: {looked.stderr}")
            found += looked.returncode != DONE
        # The other bits are in gaps and in short texts, which have no checksum.
        self.assertGreater(found, 50)

    def test_texts_without_checksums_cannot_kill_a_reader(self):
        # HDF5 trusts the sizes of texts in its global heap; see study_probe.hpp.
        archive = self.fresh("heap")
        content = archive.read_bytes()
        heap = content.find(b"GCOL")
        self.assertGreater(heap, 0)
        deaths = 0
        for bit in range(56, 64, 2):
            flipped = bytearray(content)
            size = heap + 16 + 8  # of the first text
            flipped[size + bit // 8] ^= 1 << bit % 8
            archive.write_bytes(flipped)
            found = verify(self.folder, "heap")
            self.assertEqual(found["exit_code"], POINTS_FAILED)
            if "HDF5 itself crashes or does not terminate" not in found["problems"][0]:
                continue
            deaths += 1
            for command in (("reduce", "heap"), ("run", "s.toml", "-o", "heap", "-q", "--resume"),
                            ("archive", "merge", "heap", "-o", "merged")):
                refused = culm(self.folder, *command)
                self.assertIn(refused.returncode, (BAD_INPUT, STOPPED_EARLY), command)
                self.assertIn("study.h5: damaged in a part that has no checksum", refused.stderr)
        # HDF5 1.14.5 survives all of them; where it dies, culm must have met that.
        if h5py.version.hdf5_version_tuple < (1, 14):
            self.assertGreater(deaths, 0)

    def test_truncated_file_is_found_and_not_overwritten(self):
        archive = self.fresh("cut")
        whole = archive.read_bytes()
        for length in (0, 100, len(whole) // 2, len(whole) - 1):
            archive.write_bytes(whole[:length])
            found = verify(self.folder, "cut")
            self.assertEqual(found["exit_code"], POINTS_FAILED, length)
            self.assertTrue(found["problems"])
            self.assertFalse(found["is_whole"])
            resumed = culm(self.folder, "run", "s.toml", "-o", "cut", "-q", "--resume")
            self.assertEqual(resumed.returncode, BAD_INPUT, resumed.stderr)
            self.assertEqual(archive.read_bytes(), whole[:length])

    def test_damaged_archive_is_not_trusted_by_resume(self):
        archive = self.fresh("distrusted")
        offset, size = stored_ranges(archive)["results/frequency"][0]
        content = bytearray(archive.read_bytes())
        content[offset + size // 2] ^= 1
        archive.write_bytes(content)
        resumed = culm(self.folder, "run", "s.toml", "-o", "distrusted", "-q", "--resume")
        self.assertEqual(resumed.returncode, BAD_INPUT)
        self.assertIn("datasets are damaged, the first is /results/frequency", resumed.stderr)

    def trajectory_files(self, name: str) -> list[Path]:
        return sorted((self.folder / name / "trajectories").glob("*.h5"))

    def test_missing_trajectories_are_named_and_the_tables_stay(self):
        self.fresh("parted")
        gone = self.trajectory_files("parted")[0]
        gone.unlink()
        found = verify(self.folder, "parted")
        self.assertEqual(found["exit_code"], POINTS_FAILED)
        reasons = {entry["reason"] for entry in found["archive"]["damaged"]}
        self.assertEqual(reasons, {f"parted/trajectories/{gone.name} is missing; it holds "
                                   "trajectories of the study"})
        self.assertEqual(culm(self.folder, "reduce", "parted").returncode, DONE)
        with Study(self.folder / "parted") as study:
            lost = int(found["archive"]["damaged"][0]["dataset"][-6:])
            self.assertTrue(all(study["frequency"] > 0))
            with self.assertRaisesRegex(StudyError, f"{gone.name} is missing"):
                study.positions(lost)

    def test_flipped_bits_of_trajectories_never_reach_a_reader(self):
        self.fresh("bent")
        chance = random.Random(13)
        with h5py.File(self.folder / "bent" / "study.h5") as file:
            link = file.get("particles/point_000007", getlink=True)
        path = self.folder / "bent" / link.filename
        with h5py.File(path) as part:
            data = part[link.path]["position/value"]
            place = data.id.get_offset() + chance.randrange(data.id.get_storage_size())
        content = bytearray(path.read_bytes())
        content[place] ^= 1 << chance.randrange(8)
        path.write_bytes(content)
        found = verify(self.folder, "bent")
        self.assertEqual([entry["dataset"] for entry in found["archive"]["damaged"]],
                         ["/particles/point_000007"])
        with Study(self.folder / "bent") as study:
            study.positions(6)
            with self.assertRaisesRegex(StudyError, "checksum is wrong"):
                study.positions(7)

    def test_link_to_another_file_is_not_followed(self):
        self.fresh("hostile")
        shutil.copy(self.trajectory_files("whole")[0], self.folder / "elsewhere.h5")
        with h5py.File(self.folder / "hostile" / "study.h5", "r+") as file:
            file["histories/trajectory_place"][1] = -1
            del file["particles/point_000001"]
            file["particles/point_000001"] = h5py.ExternalLink(
                str(self.folder / "elsewhere.h5"), "/particles/trajectory_0000")
        merged = culm(self.folder, "archive", "merge", "hostile", "-o", "taken")
        self.assertNotEqual(merged.returncode, DONE)
        self.assertIn("/particles/point_000001", merged.stderr)
        with Study(self.folder / "hostile") as study:
            with self.assertRaisesRegex(StudyError, "links are not followed"):
                study.positions(1)

    def test_moved_folder_keeps_its_trajectories_and_merge_makes_one_file(self):
        self.fresh("moved-from")
        (self.folder / "moved-from").rename(self.folder / "moved")
        merged = culm(self.folder, "archive", "merge", "moved", "-o", "one-file")
        self.assertEqual(merged.returncode, DONE, merged.stderr)
        self.assertFalse((self.folder / "one-file" / "trajectories").exists())
        self.assertEqual(contents(self.folder, "one-file"), contents(self.folder, "whole"))
        self.assertEqual(verify(self.folder, "one-file")["exit_code"], DONE)

    def test_read_only_archive_can_be_looked_at_and_stays_as_it_is(self):
        archive = self.fresh("closed")
        before = archive.read_bytes()
        folder = archive.parent
        archive.chmod(0o444)
        folder.chmod(0o555)
        self.addCleanup(folder.chmod, 0o755)
        for command in ("info", "status", "verify"):
            finished = culm(self.folder, "archive", command, "closed")
            self.assertEqual(finished.returncode, DONE, finished.stderr)
        self.assertEqual(archive.read_bytes(), before)
        self.assertEqual({entry.name for entry in folder.iterdir()},
                         {entry.name for entry in (self.folder / "whole").iterdir()})


class Journal(FaultTest):
    def finish(self, name: str) -> int:
        """Resumes; the tables must be those of the whole study. Returns the points computed."""
        kept = len(committed_points(self.folder, name))
        finished = culm(self.folder, "run", "long.toml", "-o", name, "-q", "--resume")
        self.assertEqual(finished.returncode, DONE, finished.stderr)
        self.assertEqual((self.folder / name / "fits.csv").read_bytes(),
                         (self.folder / "long-whole" / "fits.csv").read_bytes())
        return POINTS - kept

    def test_torn_tail_is_counted_and_computed_again(self):
        journal = self.killed("torn")
        content = journal.read_bytes()
        before = len(committed_points(self.folder, "torn"))
        last = content.rfind(MAGIC)
        journal.write_bytes(content[:last + 20])
        found = verify(self.folder, "torn")
        self.assertEqual(found["exit_code"], POINTS_FAILED)
        self.assertEqual(found["journals"][0]["torn_tail_bytes"], 20)
        self.assertGreaterEqual(len(committed_points(self.folder, "torn")), before - 1)
        self.assertGreater(self.finish("torn"), 0)

    def test_damaged_trajectory_costs_its_point_alone(self):
        self.killed("lost")
        before = committed_points(self.folder, "lost")
        path = self.folder / "lost" / "trajectories" / "rank-00000-0000.h5"
        with h5py.File(path) as part:
            data = part["particles/trajectory_0002/position/value"]
            place, size = data.id.get_offset(), data.id.get_storage_size()
        content = bytearray(path.read_bytes())
        content[place:place + size // 2] = bytes(size // 2)  # never reached the disk
        path.write_bytes(content)
        found = verify(self.folder, "lost")
        self.assertEqual(found["exit_code"], POINTS_FAILED)
        self.assertIn("does not match its checksum", found["problems"][0])
        self.assertEqual(len(committed_points(self.folder, "lost")), len(before) - 1)
        self.finish("lost")
        self.assertEqual(contents(self.folder, "lost"), contents(self.folder, "long-whole"))

    def test_zero_filled_block_costs_its_points_alone(self):
        journal = self.killed("zeros")
        content = bytearray(journal.read_bytes())
        before = len(committed_points(self.folder, "zeros"))
        # The block is in the first record that has a payload; marks have none.
        record = content.find(MAGIC)
        while content.find(MAGIC, record + 1) == record + 40:
            record += 40
        content[record + 1024:record + 3072] = bytes(2048)
        journal.write_bytes(content)
        found = verify(self.folder, "zeros")
        self.assertEqual(found["exit_code"], POINTS_FAILED)
        self.assertEqual(found["journals"][0]["damaged_regions"], 1)
        self.assertEqual(found["journals"][0]["corrupt_records"], 1)
        self.assertEqual(len(committed_points(self.folder, "zeros")), before - 1)
        self.finish("zeros")

    def test_missing_points_are_reported_as_missing(self):
        self.killed("partial")
        found = verify(self.folder, "partial")
        self.assertEqual(found["exit_code"], POINTS_FAILED)
        self.assertEqual(found["points"]["total"], POINTS)
        self.assertEqual(found["points"]["missing"], len(found["missing_points"]))
        self.assertGreater(found["points"]["missing"], 0)

    def test_changed_study_is_refused_with_what_changed(self):
        self.killed("changed")
        (self.folder / "other.toml").write_text(
            LONG_STUDY.replace("duration_s = 0.05", "duration_s = 0.04").replace("spheres = 40",
                                                                            "spheres = 41"),
            encoding="utf-8")
        refused = culm(self.folder, "run", "other.toml", "-o", "changed", "--resume")
        self.assertEqual(refused.returncode, BAD_INPUT)
        self.assertIn("stem.spheres: stored 40, now 41\n", refused.stderr)
        self.assertIn("vibration.duration_s: stored 0.05, now 0.04\n", refused.stderr)


class Merge(FaultTest):
    def test_gives_the_tables_of_the_whole_from_two_halves(self):
        self.killed("half")
        again = self.killed("other-half")
        content = again.read_bytes()
        partial = culm(self.folder, "archive", "merge", "half", "other-half", "-o", "merged")
        self.assertEqual(partial.returncode, POINTS_FAILED, partial.stderr)
        found = verify(self.folder, "merged")
        self.assertEqual(found["points"]["total"], POINTS)
        self.assertEqual(found["archive"]["damaged"], [])
        self.assertGreater(found["points"]["missing"], 0)
        self.assertEqual(again.read_bytes(), content)  # sources do not change
        with Study(self.folder / "merged") as study:
            self.assertEqual((study.statuses == "missing").sum(), found["points"]["missing"])
        finished = culm(self.folder, "run", "long.toml", "-o", "merged", "-q", "--resume")
        self.assertEqual(finished.returncode, DONE, finished.stderr)
        self.assertEqual(contents(self.folder, "merged"), contents(self.folder, "long-whole"))

    def test_refuses_different_studies(self):
        refused = culm(self.folder, "archive", "merge", "whole", "long-whole", "-o", "mixed")
        self.assertEqual(refused.returncode, BAD_INPUT)
        self.assertIn("hold different studies", refused.stderr)
        self.assertFalse((self.folder / "mixed").exists())

    def test_exported_trajectory_points_at_the_numbers_in_the_archive(self):
        target = self.folder / "whole-xdmf"
        subprocess.run([sys.executable, "-B", ROOT / "postprocess/trajectories_xdmf.py", "whole", "-o",
                        target], cwd=self.folder, check=True, capture_output=True)
        with h5py.File(self.folder / "whole" / "study.h5", "r") as file:
            positions = file["particles/point_000003/position/value"][()]
        grids = ElementTree.parse(target / "point_000003.xdmf").findall(".//Grid/Grid")
        self.assertEqual(len(grids), len(positions))
        items = grids[7].findall("Geometry/DataItem/DataItem")
        start_, stride, count = (items[0].text.split()[k:k + 3] for k in (0, 3, 6))
        self.assertEqual((start_, stride, count),
                         (["7", "0", "0"], ["1", "1", "1"], ["1", str(positions.shape[1]), "3"]))
        archive, dataset = items[1].text.split(":")
        with h5py.File(target / archive, "r") as file:
            self.assertTrue((file[dataset][7] == positions[7]).all())
        self.assertEqual(items[1].get("Dimensions").split(), [str(n) for n in positions.shape])


class Jobs(FaultTest):
    def test_second_job_on_the_same_folder_is_refused_and_the_first_finishes(self):
        first = self.stopped("shared")
        status = culm(self.folder, "archive", "status", "shared")
        second = culm(self.folder, "run", "long.toml", "-o", "shared", "-q", "--resume")
        first.send_signal(signal.SIGCONT)
        self.assertEqual(first.wait(timeout=PATIENCE), DONE)
        self.assertRegex(status.stdout, r"state +running\n")
        self.assertEqual(second.returncode, STOPPED_EARLY)
        self.assertIn("culm: another process still works in shared; waiting for it, 30 s at most",
                      second.stderr)
        self.assertIn("cannot write shared/study.lock: another process has it open; is the study "
                      "running already?", second.stderr)
        self.assertEqual((self.folder / "shared" / "fits.csv").read_bytes(),
                         (self.folder / "long-whole" / "fits.csv").read_bytes())

    def test_compute_each_point_once_if_they_start_together(self):
        # The state of the folder must not change between a job's reading and its first write.
        for attempt in range(5):
            name = f"together-{attempt}"
            jobs = [start(self.folder, "run", "s.toml", "-o", name, "-q", "--resume", ranks=1)
                    for _ in range(4)]
            codes = [job.wait(timeout=PATIENCE) for job in jobs]
            self.assertIn(DONE, codes)
            self.assertLessEqual(set(codes), {DONE, STOPPED_EARLY})
            found = verify(self.folder, name)
            self.assertEqual(found["exit_code"], DONE)
            self.assertEqual((found["repeated_outcomes"], found["journals"]), (0, []))
            self.assertEqual((self.folder / name / "fits.csv").read_bytes(),
                             (self.folder / "whole" / "fits.csv").read_bytes())
            self.assertFalse((self.folder / name / "study.lock").exists())


if __name__ == "__main__":
    unittest.main()
