#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The recordings of docs/real-data.md, which are not part of the repository:
real_recordings.py BUILD DATA.

DATA holds real/aluminium-strip and real/silicone-cantilever. Prints Markdown tables: what fit,
calibrate and diagnose answer, with 20 spheres for the strip and 56 for the beam.
"""
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STRIP_STEM = """[stem]
id = "{name}"
length_mm = {length}
density_kg_m3 = 2700
[section]
shape = "rectangle"
width_mm = 50.8
height_mm = 2.0
[[sensor]]
column = "acc_g"
quantity = "acceleration"
unit = "g"
height_mm = {sensor}
mass_g = 5
[release]
kind = "moving"
"""
STRIPS = (("L300_2cm_a", 300, 3), ("L600_2cm_a", 600, 5), ("L600_4cm_a", 600, 5))  # mm, s
# Of docs/measurements.md, for a beam that is held level and released.
BEAM = """[source]
file = "beam.c3d"
[time]
release_s = "detect"
[motion]
axis = [-1, 0, 0]
zero = "before_release"
[[height]]
height_mm = 100
markers = ["Tip - 1", "Tip - 2", "Tip - 3"]
[stem]
id = "{name}"
length_mm = 100
density_kg_m3 = 1070
specimen = "beam"
[section]
shape = "rectangle"
width_mm = 30
height_mm = 30
[release]
kind = "held_straight"
[measurement]
reading = "material"
gravity_direction = "transverse"
"""
BEAMS = ("beam_gravity_V2_a", "beam_load52_V2_a")


class Culm:
    def __init__(self, build: Path):
        self.program = build / "src" / "cli" / "culm"
        launch = "mpirun --oversubscribe -n 2" + (" --allow-run-as-root" if os.geteuid() == 0 else "")
        self.launch = shlex.split(launch)

    def run(self, *arguments, ranks: int = 1) -> tuple[dict, float]:
        """The JSON and the seconds of a command."""
        with tempfile.NamedTemporaryFile(suffix=".json") as file:
            command = [*(self.launch if ranks > 1 else ()), self.program, *map(str, arguments),
                       "--quiet", "--json", file.name]
            began = time.monotonic()
            done = subprocess.run(command, text=True, capture_output=True, check=False)
            text = Path(file.name).read_text("utf-8")
            if not text:
                raise SystemExit(f"{shlex.join(map(str, command))}: exit code {done.returncode}\n"
                                 f"{done.stdout}{done.stderr}")
            return json.loads(text), time.monotonic() - began


def span(points: list[dict], key: str, digits: int) -> str:
    return f"{points[0][key]:.{digits}f} … {points[-1][key]:.{digits}f}"


def interval(estimate: dict | None, scale: float = 1.0) -> str:
    if estimate is None:
        return "absent"
    low, high = (scale * bound for bound in estimate["interval"])
    return f"{low:.2f} … {high:.2f}"


def with_half_width(parameter: dict, scale: float, digits: int) -> str:
    low, high = (scale * bound for bound in parameter["interval"])
    return f"{scale * parameter['value']:.{digits}f} ± {(high - low) / 2:.{digits}f}"


def answer_of(found: dict) -> list[tuple[str, str]]:
    """The verdict, the best explanation, and the residual that this has."""
    likeliest = found["explanations"][0]["effects"] if found["explanations"] else []
    headline = found["sentences"][0].replace("|", "/")
    return [("verdict", headline),
            ("best explanation", " + ".join(likeliest) or "none"),
            ("its share of the misfit, %", f"{100 * found['explained']:.0f}"),
            ("unexplained, % of the swing", f"{100 * found['unexplained_share_of_swing']:.1f}")]


def backbone_of(fit: dict) -> list[tuple[str, str]]:
    first = next(each for each in fit["stems"][0]["backbone"] if each["mode"] == 1)
    laws = first["laws"] or {}
    points = first["points"]
    return [("windows of eight cycles", str(len(points))),
            ("amplitude at the sensor, mm", span(points, "amplitude_mm", 2)),
            ("frequency of mode 1, Hz", span(points, "frequency_hz", 4)),
            ("damping ratio of mode 1", span(points, "damping_ratio", 5)),
            ("power of the damping (95 %)", interval(laws.get("power_exponent"))),
            ("power of the softening (95 %)", interval(laws.get("softening_exponent")))]


def plate_of(stem: dict) -> list[tuple[str, str]]:
    """What the chain with the air of a plate has; why it has nothing where its fit failed."""
    wanted = (("Y, GPa", "bond_youngs_modulus_pa", 1e-9, 1),
              ("D, drag at KC = 1", "plate_air.drag_amplitude", 1, 2),
              ("k, added mass at KC = 1", "plate_air.mass_amplitude", 1, 3))
    if "parameters" not in stem:
        return [(what, f"failed: {stem['failure']}") for what, *_ in wanted]
    return [(what, with_half_width(stem["parameters"][key], scale, digits))
            for what, key, scale, digits in wanted]


def strip(culm: Culm, data: Path, folder: Path, name: str, length: int, window: float) -> dict:
    place = folder / name
    place.mkdir()
    (place / "stem.toml").write_text(
        STRIP_STEM.format(name=name, length=length, sensor=length - 60), "utf-8")
    (place / "deflection.csv").write_bytes(
        (data / "real" / "aluminium-strip" / f"{name}_acceleration.csv").read_bytes())
    fit, _ = culm.run("fit", place, "--backbone", "--window", window)
    chain = ("--spheres", 20, "--window", window)
    stem = culm.run("calibrate", place, "--with", "still_air,plate_air", *chain)[0]["stems"][0]
    diagnosis, seconds = culm.run("diagnose", place, *chain, ranks=2)
    return dict(backbone_of(fit) + plate_of(stem) + answer_of(diagnosis)
                + [("time of the diagnosis, s", f"{seconds:.0f}")])


def beam(culm: Culm, data: Path, folder: Path, name: str) -> dict:
    place = folder / name
    mapping = folder / "mapping.toml"
    mapping.write_text(BEAM.format(name=name), "utf-8")
    subprocess.run([culm.program, "import", mapping, "-o", place, "--recording",
                    data / "real" / "silicone-cantilever" / f"{name}.c3d"],
                   capture_output=True, check=True)
    fit, _ = culm.run("fit", place, "--backbone")
    diagnosis, seconds = culm.run("diagnose", place, ranks=2)
    return dict(backbone_of(fit) + answer_of(diagnosis)
                + [("time of the diagnosis, s", f"{seconds:.0f}")])


def hidden_mass(culm: Culm, folder: Path) -> str:
    """The mass of 52 g, which one of the two recordings carries and neither states, by culm."""
    found, _ = culm.run("diagnose", *(folder / name for name in BEAMS), "--candidates", "tip_mass",
                        ranks=2)
    masses = [f"{key.partition('@')[2] or 'both'}: {with_half_width(each, 1e3, 1)} g"
              for key, each in found["parameters"].items() if key.startswith("tip_mass.mass_kg")]
    return f"{found['verdict']}; {', '.join(masses) or 'no mass'}"


def print_table(title: str, columns: dict[str, dict]):
    print(f"{title}\n\n| what | {' | '.join(columns)} |\n|{'---|' * (len(columns) + 1)}")
    for what in next(iter(columns.values())):
        print(f"| {what} | {' | '.join(column[what] for column in columns.values())} |")
    print()


def main(build: Path, data: Path):
    culm = Culm(build)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print_table("Strip", {which: strip(culm, data, folder, which, length, window)
                              for which, length, window in STRIPS})
        print_table("Beam", {which: beam(culm, data, folder, which) for which in BEAMS})
        print(f"Hidden mass of 52 g, with the candidate tip_mass only: {hidden_mass(culm, folder)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
