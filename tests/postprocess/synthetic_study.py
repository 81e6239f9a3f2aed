# SPDX-License-Identifier: BSD-3-Clause
"""A small study whose tips follow Eq. 1 exactly, in the layout of docs/archive-format.md."""
import json
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

COMPLETED, FAILED, MISSING = 0, 1, 2
TEXT = h5py.string_dtype("utf-8")
STATUS = h5py.enum_dtype({"completed": COMPLETED, "failed": FAILED, "missing": MISSING}, "u1")
INITIAL_DEFLECTION = 15e-3  # m
DURATION = 0.1  # s
SAMPLES = 401
HEIGHTS = np.array([0.05, 0.1])  # m
SPHERES = 4


@dataclass
class Synthetic:
    """The factorial design of some dampings (slow) and moduli (fast), and its exact answers.

    √Y = 570 b2 + 100 and β = −260 b1 + 3, except for a small curvature that causes residuals.
    """

    dampings: tuple = (25.0, 100.0, 150.0, 200.0)
    moduli_gpa: tuple = (1.0, 5.0, 10.0)
    failed_point: int | None = 4
    missing_point: int | None = 9
    store: str = "full"  # "fit", "tip" or "full"
    frequency_factor: float = 1.0
    extra_factors: dict = field(default_factory=dict)
    extra_settings: dict = field(default_factory=dict)
    is_published_stem: bool = True

    def __post_init__(self):
        damping, modulus = np.meshgrid(self.dampings, self.moduli_gpa, indexing="ij")
        self.damping, self.modulus_gpa = damping.ravel(), modulus.ravel()
        self.points = self.damping.size
        self.status = np.full(self.points, COMPLETED, dtype=np.uint8)
        if self.failed_point is not None:
            self.status[self.failed_point] = FAILED
        if self.missing_point is not None:
            self.status[self.missing_point] = MISSING
        self.is_completed = self.status == COMPLETED
        bend = 1.0 - 1e-4 * self.damping
        root = np.sqrt(1e9 * self.modulus_gpa)
        self.frequency = self.frequency_factor * bend * (root - 100.0) / 570.0
        self.decay_per_cycle = (3.0 - self.damping) / 260.0 * (1.0 + 1e-5 * self.damping)
        self.decay_rate = self.decay_per_cycle * self.frequency
        self.time = np.linspace(0.0, DURATION, SAMPLES)

    def tip(self, point):
        """Eq. 1 with b0 = 1; (S), m."""
        decay = np.exp(self.decay_rate[point] * self.time)
        return INITIAL_DEFLECTION * decay * np.cos(2 * np.pi * self.frequency[point] * self.time)

    def height_deflection(self, point):
        """(S, H), m."""
        return self.tip(point)[:, None] * (HEIGHTS / 0.15) ** 2

    def positions(self, point):
        """(S, N, 3), m: straight except for the last sphere."""
        positions = np.zeros((SAMPLES, SPHERES, 3))
        positions[:, :, 0] = 0.05 * np.arange(SPHERES)
        positions[:, -1, 1] = self.tip(point)
        return positions

    def columns(self):
        """Result columns with their units."""
        none = np.zeros(self.points)
        table = {}
        for name, unit, values in (
            ("amplitude", "1", np.ones(self.points)),
            ("decay_rate", "1/s", self.decay_rate),
            ("frequency", "Hz", self.frequency),
            ("decay_per_cycle", "1", self.decay_per_cycle),
        ):
            table[name] = (unit, values)
            table[f"{name}_standard_error"] = (unit, 1e-6 * np.abs(values))
        table |= {"rms_residual": ("1", none), "r_squared": ("1", none + 1.0)}
        table |= {"steps": ("1", none + 1000.0), "wall_seconds": ("s", none + 0.05)}
        blank = np.where(self.is_completed, 0.0, np.nan)
        return {name: (unit, values + blank) for name, (unit, values) in table.items()}

    def factors(self):
        """Factor columns with their units."""
        given = {"bond_damping": ("1", self.damping)}
        given["bond_youngs_modulus_gpa"] = ("GPa", self.modulus_gpa)
        return given | self.extra_factors

    def provenance(self):
        """Entries of /provenance except the configuration."""
        return {"compiler": "GNU 12.2"}

    def write(self, folder):
        """Writes study.h5 and summary.json to the folder."""
        folder = Path(folder)
        write_archive(folder / "study.h5", self)
        write_summary(folder, self.summary())
        return folder

    def residuals_percent(self, response):
        """Of the least-squares line of "sqrt_youngs_modulus" or "bond_damping", in per cent of the
        largest value."""
        rows = self.is_completed
        x, y = {"sqrt_youngs_modulus": (self.frequency, np.sqrt(1e9 * self.modulus_gpa)),
                "bond_damping": (self.decay_per_cycle, self.damping)}[response]
        slope, intercept = np.polyfit(x[rows], y[rows], 1)
        return 100.0 * (y[rows] - intercept - slope * x[rows]) / np.abs(y[rows]).max()

    def summary(self):
        """The summary in the format of `culm reduce`; the laws are least-squares lines."""
        rows = self.is_completed
        root = np.sqrt(1e9 * self.modulus_gpa[rows])
        failed = [] if self.failed_point is None else [self.failed_point]
        return {
            "points": self.points,
            "completed": int(rows.sum()),
            "failed": [{"point": p, "kind": "not_a_number", "reason": "NaN"} for p in failed],
            "ranks": 1,
            "wall_s": 1.0,
            "is_published_stem": self.is_published_stem,
            "regression": {
                "sqrt_youngs_modulus": law_entry("frequency", self.frequency[rows], root),
                "bond_damping": law_entry(
                    "decay_per_cycle", self.decay_per_cycle[rows], self.damping[rows]
                ),
            },
        }


def law_entry(predictor_name, predictor, response):
    if response.size < 3 or np.ptp(response) == 0.0:
        return {"reason": "the points do not determine a law."}
    slope, intercept = np.polyfit(predictor, response, 1)
    residuals = response - intercept - slope * predictor
    percent = 100.0 * residuals / np.abs(response).max()
    share = residuals.var() / response.var()
    return {
        "intercept": intercept,
        "slope": slope,
        "adjusted_r2": 1.0 - share * (response.size - 1) / (response.size - 2),
        "interval": {"intercept": [intercept - 1, intercept + 1], "slope": [slope - 1, slope + 1]},
        "predictor": predictor_name,
        "unit": "1",
        "terms": [],
        "adjusted_r2_full": 1.0,
        "largest_residual_percent": float(np.abs(percent).max()),
    }


def write_summary(folder, summary):
    (Path(folder) / "summary.json").write_text(json.dumps(summary), encoding="utf-8")


def add(group, name, values, unit, chunk=None, compressed=True):
    """Adds a dataset that follows the format: chunked, with a checksum and a unit."""
    options = {"shuffle": True, "compression": "gzip", "compression_opts": 1} if compressed else {}
    dataset = group.create_dataset(
        name, data=values, chunks=chunk or values.shape, fletcher32=True, **options
    )
    dataset.attrs["unit"] = unit
    return dataset


def add_text(group, name, text):
    encoded = text.encode("utf-8")
    dataset = group.create_dataset(
        name, data=encoded, dtype=h5py.string_dtype("utf-8", len(encoded))
    )
    dataset.attrs["unit"] = "1"
    dataset.attrs["crc32"] = np.int64(zlib.crc32(encoded))


def add_table(group, columns):
    if columns:
        group.attrs.create("columns", list(columns), dtype=TEXT)
    for name, (unit, values) in columns.items():
        add(group, name, values, unit).attrs["description"] = f"the {name}"


def write_archive(path, study):
    with h5py.File(path, "w", libver=("v110", "v110")) as file:
        file.attrs["format"] = "culm-study"
        file.attrs["format_version"] = "1.0"
        file.attrs["points"] = np.int64(study.points)
        file.attrs["spheres"] = np.int64(SPHERES)
        file.attrs["trajectory_compression"] = np.int64(0)
        file.create_group("h5md").attrs["version"] = np.array([1, 1], dtype=np.int32)
        add_provenance(file.create_group("provenance"), study)
        add(file.create_group("design"), "point", np.arange(study.points), "1")
        add_table(file["design"], study.factors())
        add_results(file.create_group("results"), study)
        if study.store != "fit":
            add_histories(file, study)


def add_provenance(group, study):
    entries = study.provenance()
    group.attrs.create("entries", [*entries, "config"], dtype=TEXT)
    for name, text in entries.items():
        group.attrs[name] = text
    add_text(group, "config", "[factors]\n# β\n")
    settings = {"law.name": "schramm2019", "reduce.window_s": DURATION, "study.store": study.store}
    settings |= {"stem.density_kg_m3": 125, "release.tip_deflection_mm": 15}
    settings |= study.extra_settings
    add_text(group, "identity", "".join(f"{k} = {v}\n" for k, v in sorted(settings.items())))


def add_results(group, study):
    add_table(group, study.columns())
    add(group, "status", study.status.astype(STATUS), "1")
    is_failed = study.status == FAILED
    for name, text in (("failure_kind", "not_a_number"), ("failure_reason", "NaN at 1 µs, β")):
        texts = [text.encode("utf-8") if failed else b"" for failed in is_failed]
        width = max(1, max(map(len, texts)))
        add(group, name, np.array(texts, dtype=h5py.string_dtype("utf-8", width)), "1")


def add_histories(file, study):
    def rows(history, shape):
        nothing = np.full(shape, np.nan)
        done = study.is_completed
        return np.array([history(p) if done[p] else nothing for p in range(study.points)])

    group = file.create_group("histories")
    add(group, "time", study.time, "s")
    add(group, "tip_deflection", rows(study.tip, SAMPLES), "m", chunk=(1, SAMPLES))
    if study.store != "full":
        return
    add(group, "heights", HEIGHTS, "m")
    shape = (SAMPLES, HEIGHTS.size)
    add(group, "height_deflection", rows(study.height_deflection, shape), "m", chunk=(1, *shape))
    add(group, "step", np.arange(SAMPLES), "1")
    for point in np.flatnonzero(study.is_completed):
        particles = file.create_group(f"particles/point_{point:06d}")
        particles.create_group("box").attrs["dimension"] = np.int32(3)
        position = particles.create_group("position")
        position["step"], position["time"] = group["step"], group["time"]
        add(position, "value", study.positions(point), "m", compressed=False)
