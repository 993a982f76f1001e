#!/usr/bin/env python3
"""Writes the small files in ../files with third-party writers, and their expected contents into ../files/expected.json.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install pynrrd nibabel SimpleITK vtk numpy tifffile pillow pydicom zarr ome-zarr h5py netCDF4 xarray trimesh plyfile
    /tmp/venv/bin/python tests/formats/make            # or only some: tests/formats/make dicom zarr

Voxel i (x fastest) of a volume of 5x4x3 voxels has the value slope * i + intercept. Affine transforms are those that the readers of
the same libraries return, with x to the right, y to the front and z up.
"""
import importlib, json, sys

from common import HERE, expected

# The folders that each script writes.
SCRIPTS = dict(nrrds=["nrrd"], niftis=["nifti"], metaimages=["metaimage"], vtks=["vtk"], numpys=["numpy", "bov"], tiffs=["tiff", "png"],
               dicoms=["dicom"], zarrs=["zarr"], hdf5s=["hdf5"], labels=["labels"], channels=["channels"], conventions=["conventions"],
               mincs=["minc"], netcdfs=["netcdf"], surfaces=["surfaces"])

if __name__ == "__main__":
    wanted = {script: folders for script, folders in SCRIPTS.items() if not sys.argv[1:] or set(folders) & set(sys.argv[1:])}
    made = sum(wanted.values(), [])
    told = HERE / "expected.json"
    kept = [entry for entry in json.loads(told.read_text()) if entry["file"].split("/")[0] not in made] if told.exists() else []
    for script in wanted:
        getattr(importlib.import_module(script), script)()
    lines = ",\n".join(json.dumps({k: v for k, v in entry.items() if v is not None}) for entry in kept + expected)
    told.write_text(f"[\n{lines}\n]\n")
