# SPDX-License-Identifier: BSD-3-Clause
"""Reads the example study with h5py, following the layout in docs/archive-format.md."""
import importlib.util
import sys

import h5py
import numpy as np

COMPLETED, FAILED, MISSING = 0, 1, 2


def check_datasets(study):
    """Every dataset states its unit; every array is chunked and has a checksum."""

    def check(name, item):
        if not isinstance(item, h5py.Dataset):
            return
        assert isinstance(item.attrs["unit"], str), name
        if item.shape == ():
            assert "crc32" in item.attrs, name
            return
        assert item.chunks is not None and item.fletcher32, name
        is_history = name.endswith(("/tip_deflection", "/height_deflection", "/position/value"))
        assert item.shuffle != is_history, name
        assert (item.compression == "gzip") != is_history, name

    study.visititems(check)


def check_tables(study):
    assert study.attrs["format"] == "culm-study"
    assert study.attrs["format_version"] == "1.1"
    assert list(study["design"].attrs["columns"]) == ["bond_youngs_modulus", "bond_damping"]
    assert study["design/point"][:].tolist() == list(range(6))
    modulus = study["design/bond_youngs_modulus"]
    assert modulus.attrs["unit"] == "Pa" and modulus[1] == 2e9
    assert modulus.attrs["description"] == "Young's modulus of the bonds"
    status = study["results/status"]
    names = h5py.check_enum_dtype(status.dtype)
    assert names == {"completed": COMPLETED, "failed": FAILED, "missing": MISSING}
    assert status[:].tolist() == [0, 0, FAILED, 0, MISSING, 0]
    reasons = study["results/failure_reason"].asstr()[:]
    assert reasons[2].endswith("(β = 200)") and reasons[4] == ""
    frequency = study["results/frequency"][:]
    assert np.isnan(frequency).tolist() == [False, False, True, False, True, False]
    config = study["provenance/config"].asstr()[()]
    assert len(config) > 100_000 and config.endswith("\nβ = [1, 2]\n")
    assert study["provenance"].attrs["compiler"] == "GNU 12.2"


def check_h5md(study):
    """The mandatory elements of H5MD 1.1."""
    assert study["h5md"].attrs["version"].tolist() == [1, 1]
    assert study["h5md/author"].attrs["name"] == "culm"
    assert study["h5md/creator"].attrs["name"] == "culm"
    assert study["h5md/creator"].attrs["version"] == "0.1.0"
    assert sorted(study["particles"]) == [f"point_{p:06}" for p in (0, 1, 3, 5)]
    group = study["particles/point_000003"]
    assert group["box"].attrs["dimension"] == 3
    assert list(group["box"].attrs["boundary"]) == ["none"] * 3
    position = group["position"]
    assert position["value"].shape == (40, 5, 3) and position["value"].dtype == np.float64
    assert position["value"].attrs["unit"] == "m" and position["time"].attrs["unit"] == "s"
    assert position["step"][:].tolist() == list(range(40))
    assert np.allclose(position["time"][:], 5e-5 * np.arange(40), rtol=1e-15, atol=0.0)
    expected = 1e-3 * np.sin(0.1 * (5000 + np.arange(600)) + 3)
    # The argument is near 560, so its rounding error (a fused multiply-add may change it) is 1e-13.
    # With the amplitude of 1e-3 this is 1e-16.
    assert np.allclose(position["value"][:].ravel(), expected, rtol=0.0, atol=1e-15)


def check_mdanalysis(path):
    """MDAnalysis lacks the metre as a unit of length, so the metre is added to its table."""
    import MDAnalysis
    from MDAnalysis.coordinates.H5MD import H5MDReader

    H5MDReader._unit_translation["length"]["m"] = "m"
    with h5py.File(path) as study:
        expected = study["particles/point_000000/position/value"][7]
    universe = MDAnalysis.Universe.empty(5)
    universe.load_new(path, format="H5MD", convert_units=False)
    assert len(universe.trajectory) == 40
    assert universe.trajectory[7].dimensions is None
    # MDAnalysis stores positions in single precision.
    assert np.allclose(universe.atoms.positions, expected, rtol=1e-6, atol=1e-10)


def main():
    path = sys.argv[1]
    with h5py.File(path, "r") as study:
        check_datasets(study)
        check_tables(study)
        check_h5md(study)
    if importlib.util.find_spec("MDAnalysis"):
        check_mdanalysis(path)
        print("MDAnalysis: read")
    print("h5py: read")


if __name__ == "__main__":
    main()
