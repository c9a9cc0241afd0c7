# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""What test_io asks of a result file that only a reader of its own can answer.

    io_check.py layout FILE      H5MD 1.1, shapes, units, shared step and time
    io_check.py same A B         the same frames, series, profiles, parameters and last state
    io_check.py xdmf FILE        OUT.xdmf beside FILE names arrays that are there, of that size
    io_check.py opens FILE       every array can be read
    io_check.py foreign FILE     makes an HDF5 file that is no result
    io_check.py spoil FILE SLOT  changes one number in a checkpoint
"""
import os
import sys
import xml.etree.ElementTree as xml

import h5py
import numpy as np


def arrays(file):
    found = {}
    file.visititems(lambda name, item: found.setdefault(name, item) if isinstance(item, h5py.Dataset) else None)
    return found


def elements(group):
    return {name: item for name, item in group.items() if isinstance(item, h5py.Group) and "value" in item}


def layout(path):
    with h5py.File(path) as f:
        assert list(f["h5md"].attrs["version"]) == [1, 1]
        assert f["h5md/creator"].attrs["name"] == "ryusa" and f["h5md/creator"].attrs["version"]
        assert f["h5md/author"].attrs["name"]
        grains = f["particles/grains"]
        n = grains["id"].shape[0]
        assert (grains["id"][:] == np.arange(n)).all()
        assert grains["box"].attrs["dimension"] == 2 and len(grains["box"].attrs["boundary"]) == 2
        assert grains["box/edges"].shape == (2,)
        for name, item in elements(grains).items():
            tail = {"spin": (n,)}.get(name, (n, 2))
            assert item["value"].shape[1:] == tail, name
            assert item["value"].shape[0] == item["step"].shape[0] == item["time"].shape[0]
            assert item["value"].attrs["unit"] and item["time"].attrs["unit"] == "s"
            assert item["step"] == grains["position/step"], "step is shared"
        assert grains["velocity/value"].attrs["unit"] == "m s-1"
        assert grains["density"].attrs["unit"] == "kg m-3"
        observables = f["observables"]
        series = {**elements(observables), **elements(observables["energy"])}
        for name in ("q_star", "q_b", "bed_level", "kinetic_energy", "kinetic", "gravity", "elastic_normal",
                     "elastic_tangential", "fluid_work", "loss_impact", "loss_dashpot", "loss_friction",
                     "loss_opening", "integration"):
            assert series[name]["value"].shape == series[name]["step"].shape, name
            assert series[name]["value"].attrs["unit"]
        steps = series["q_star"]["step"][:]
        assert (np.diff(steps) > 0).all() and steps[0] == 0
        flux = observables["flux"].attrs
        for name in ("q_star_mean", "q_star_standard_error", "autocorrelation_time", "samples",
                     "equilibration_time", "equilibration_method", "convention"):
            assert name in flux, name
        assert "sphere volumes over a slab of width d" in flux["convention"]
        for name in ("z", "phi", "u_grain", "u_fluid", "tau_fluid", "tau_grain"):
            assert observables["profile"][name].shape == observables["profile/z"].shape
            assert observables["profile"][name].attrs["unit"]
        mean = observables["profile_series/phi/value"][:]
        late = observables["profile_series/phi/time"][:] > 0.05
        assert np.allclose(observables["profile/phi"][:], mean[late].mean(axis=0), rtol=1e-14)
        assert f["cost"].attrs["threads"] == 2 and f["cost/stages"].attrs["contact"] == 0.5
        parameters = f["parameters"].attrs
        assert parameters["contact.law"] == "energy" and parameters["time.step"] == 2e-5
        assert f["parameters/units"].attrs["grains.density"] == "kg/m^3"
        assert "columns: 6" in f["parameters/scene"].asstr()[()]
        assert f["checkpoint"].attrs["finished"] == 1 and len(f["checkpoint"].attrs["state_hash"]) == 16


def newest(f):
    return max((slot for slot in f["checkpoint"].values() if isinstance(slot, h5py.Group) and "sequence" in slot.attrs),
               key=lambda slot: slot.attrs["sequence"])


def same(first, second):
    with h5py.File(first) as a, h5py.File(second) as b:
        left, right = arrays(a), arrays(b)
        names = {name for name in left if not name.startswith(("checkpoint/a/", "checkpoint/b/"))}
        assert names == {name for name in right if not name.startswith(("checkpoint/a/", "checkpoint/b/"))}
        for name in sorted(names - {"parameters/scene"}):
            assert left[name].shape == right[name].shape, (name, left[name].shape, right[name].shape)
            assert left[name][()].tobytes() == right[name][()].tobytes(), name
        assert a["checkpoint"].attrs["state_hash"] == b["checkpoint"].attrs["state_hash"]
        p, q = newest(a), newest(b)
        for name, item in arrays(p).items():
            n = p.attrs["contacts"] if name.startswith("contacts/") else item.shape[0]
            assert item[:n].tobytes() == q[name][:n].tobytes(), name
        for name in a["parameters"].attrs:
            u, v = a["parameters"].attrs[name], b["parameters"].attrs[name]
            assert u == v or (u != u and v != v), name


def xdmf(path):
    root = os.path.splitext(path)[0] if path.endswith(".h5") else path
    tree = xml.parse(root + ".xdmf").getroot()
    assert tree.tag == "Xdmf"
    collection = tree.find("Domain/Grid")
    assert collection.get("CollectionType") == "Temporal"
    with h5py.File(path) as f:
        times = f["particles/grains/position/time"][:]
        grids = collection.findall("Grid")
        assert len(grids) == len(times) > 0
        for k, grid in enumerate(grids):
            assert float(grid.find("Time").get("Value")) == times[k]
            n = int(grid.find("Topology").get("NumberOfElements"))
            assert grid.find("Geometry").get("GeometryType") == "XY"
            names = {item.get("Name") for item in grid.findall("Attribute")}
            assert {"diameter", "velocity", "spin"} <= names
            for item in grid.iter("DataItem"):
                if item.get("Format") == "HDF":
                    name, where = item.text.strip().split(":")
                    assert name == "./" + os.path.basename(path), "the file without its folder"
                    size = tuple(int(word) for word in item.get("Dimensions").split())
                    assert f[where].shape == size, where
                    kind = {"Float": "f", "Int": "i"}[item.get("NumberType")]
                    assert f[where].dtype.kind == kind and f[where].dtype.itemsize == int(item.get("Precision"))
                if item.get("ItemType") == "HyperSlab":
                    slab, data = item.findall("DataItem")
                    start, stride, count = np.array(slab.text.split(), dtype=int).reshape(3, -1)
                    assert start[0] == k and (stride == 1).all() and count[0] == 1 and count[1] == n
                    assert [int(word) for word in item.get("Dimensions").split()] == list(count[1:])
                    assert len(count) == len(data.get("Dimensions").split())


def opens(path):
    with h5py.File(path) as f:
        for item in arrays(f).values():
            item[()]


def foreign(path):
    with h5py.File(path, "w") as f:
        f["numbers"] = [1, 2, 3]


def spoil(path, slot):
    with h5py.File(path, "r+") as f:
        f[f"checkpoint/{slot}/grains/x"][3] += 1e-9


if __name__ == "__main__":
    {"layout": layout, "same": same, "xdmf": xdmf, "opens": opens, "foreign": foreign,
     "spoil": spoil}[sys.argv[1]](*sys.argv[2:])
