"""Takes GLB files through Blender and compares the poses before and after.

    python round_trip.py OUT FILE.glb ...

Each file is imported, played and exported again; both files are then posed by the format's own rules, here, and every
vertex of one looked for in the other. Prints one line a file; ends with 1 where a vertex is further away than a ten
thousandth of the model's size: Blender computes in single precision, and creatures stand hundreds of units from 0.
"""

import json
import pathlib
import struct
import sys

import bpy
import numpy as np
from scipy.spatial import cKDTree

TYPES = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class File:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        length = struct.unpack("<I", data[12:16])[0]
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]

    def read(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype("<" + TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        rows = [np.frombuffer(self.binary, kind, width, start + i * stride) for i in range(accessor["count"])]
        return np.array(rows, float)

    def tracks(self):
        """For each channel: node, property, times from the first key on, values, whether they hold."""
        animation = self.json["animations"][0]
        start = min(self.read(s["input"])[0, 0] for s in animation["samplers"])
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            times = self.read(sampler["input"])[:, 0] - start
            holds = sampler.get("interpolation") == "STEP"
            yield channel["target"]["node"], channel["target"]["path"], times, self.read(sampler["output"]), holds

    def pose(self, tracks, time):
        """All skinned vertices at a time, by the name of their node."""
        nodes = self.json["nodes"]
        local = [
            {
                "translation": np.array(n.get("translation", [0, 0, 0]), float),
                "rotation": np.array(n.get("rotation", [0, 0, 0, 1]), float),
                "scale": np.array(n.get("scale", [1, 1, 1]), float),
            }
            for n in nodes
        ]
        for node, path, times, values, holds in tracks:
            after = int(np.searchsorted(times, time + 1e-6))
            a, b = max(after - 1, 0), min(after, len(times) - 1)
            share = 0.0 if holds or a == b else np.clip((time - times[a]) / (times[b] - times[a]), 0, 1)
            first, second = values[a], values[b]
            if path == "rotation" and first @ second < 0:
                second = -second
            local[node][path] = first + (second - first) * share
        world = {}

        def place(node, above):
            t, (x, y, z, w), s = (local[node][k] for k in ("translation", "rotation", "scale"))
            x, y, z, w = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
            turn = np.array(
                [
                    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
                ]
            )
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = turn * s, t
            world[node] = above @ matrix
            for child in nodes[node].get("children", []):
                place(child, world[node])

        for root in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            place(root, np.eye(4))
        posed = {}
        for node in nodes:
            if "mesh" not in node or "skin" not in node:
                continue
            skin = self.json["skins"][node["skin"]]
            back = self.read(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            moved = np.stack([world[j] @ m for j, m in zip(skin["joints"], back)])
            lists = self.json["meshes"][node["mesh"]]["primitives"][0]["attributes"]
            places, weights = self.read(lists["POSITION"]), self.read(lists["WEIGHTS_0"])
            joints = self.read(lists["JOINTS_0"]).astype(int)
            weights /= weights.sum(1, keepdims=True)
            places = np.c_[places, np.ones(len(places))]
            posed[node["name"]] = np.einsum("vk,vkij,vj->vi", weights, moved[joints], places)[:, :3]
        return posed


def through_blender(path, out, fps):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps, bpy.context.scene.render.fps_base = round(fps), round(fps) / fps
    bpy.ops.import_scene.gltf(filepath=str(path))
    bpy.ops.export_scene.gltf(filepath=str(out), export_format="GLB", export_extras=True)


def main():
    out, files = pathlib.Path(sys.argv[1]), sys.argv[2:]
    failed = False
    for index, path in enumerate(files):
        before = File(path)
        clip = before.json["scenes"][0]["extras"]["clip"]
        again = out / f"{index}.glb"
        through_blender(path, again, clip["fps"])
        after = File(again)
        tracks = [list(before.tracks()), list(after.tracks())]
        worst = size = 0.0
        for frame in range(clip["frames"]):
            poses = [f.pose(t, frame / clip["fps"]) for f, t in zip((before, after), tracks)]
            assert poses[0].keys() == poses[1].keys(), f"{path}: other meshes come back"
            for name, places in poses[0].items():
                worst = max(worst, cKDTree(poses[1][name]).query(places)[0].max())
                size = max(size, np.ptp(places, axis=0).max())
        failed |= worst > 1e-4 * size
        print(f"{path}: {clip['frames']} frames, {size:.0f} units long, comes back within {worst:.5f}")
    sys.exit(int(failed))


main()
