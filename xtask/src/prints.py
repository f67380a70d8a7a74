"""Whether STL files are closed manifold solids, by trimesh and manifold3d. Prints one line a file that is not, and a count."""
import sys
import manifold3d
import numpy
import trimesh

bad = 0
for path in sys.argv[1:]:
    mesh = trimesh.load(path)  # joins corners that lie in one place
    said = []
    if not mesh.is_watertight:
        said.append("not watertight")
    if not mesh.is_winding_consistent:
        said.append("winding differs")
    if not mesh.is_volume or mesh.volume <= 0:
        said.append("no volume")
    if mesh.body_count != 1:
        said.append(f"{mesh.body_count} pieces")
    if mesh.area_faces.min() <= 0:
        said.append("a face without an area")
    solid = manifold3d.Manifold(manifold3d.Mesh(mesh.vertices.astype(numpy.float32), mesh.faces.astype(numpy.uint32)))
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        said.append(f"manifold3d: {solid.status()}")
    elif abs(solid.volume() / mesh.volume - 1) > 1e-3:
        said.append(f"manifold3d holds {solid.volume()}, trimesh {mesh.volume}")
    if said:
        bad += 1
        print(f"{path}: {', '.join(said)}")
print(f"{len(sys.argv) - 1} files, {bad} bad")
sys.exit(1 if bad else 0)
