"""Files that refer to other files, which are not opened."""

import io
import json
import os
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import rasterio
import trimesh

import neurbs


def saved_mesh(path: Path) -> None:
    net = np.stack([*np.indices((4, 5), float), np.ones((4, 5))], axis=-1)
    neurbs.save(neurbs.NurbsSurface(net).tessellate(shape=(4, 5)), path)


def test_a_raster_does_not_lead_to_another_file(tmp_path: Path, rng: np.random.Generator) -> None:
    secret = tmp_path / "secret.tif"
    shape = {"height": 8, "width": 9, "count": 1, "dtype": "float64"}
    transform = rasterio.transform.from_origin(0, 8, 1, 1)
    with rasterio.open(secret, "w", driver="GTiff", transform=transform, **shape) as file:
        file.write(rng.random((8, 9)), 1)
    assert len(neurbs.read_points(secret)) == 72
    leading = tmp_path / "leading.tif"
    leading.write_text(
        f"""<VRTDataset rasterXSize="9" rasterYSize="8"><VRTRasterBand dataType="Float64" band="1">
        <SimpleSource><SourceFilename relativeToVRT="0">{secret}</SourceFilename>
        <SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"""
    )
    with pytest.raises(neurbs.NeurbsError, match=r"must be a whole \.tif file"):
        neurbs.read_points(leading)


def named_by_glb(path: Path, name: str) -> None:
    saved_mesh(path)
    whole = path.read_bytes()
    (length,) = struct.unpack_from("<I", whole, 12)
    document = json.loads(whole[20 : 20 + length])
    document["buffers"][0]["uri"] = name
    document["images"] = [{"uri": name}]
    document["textures"] = [{"source": 0}]
    document["materials"][0]["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}}
    text = json.dumps(document).encode()
    text = text.ljust(len(text) + -len(text) % 4)
    rest = struct.pack("<I4s", len(text), b"JSON") + text
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(rest)) + rest)


def named_by_obj(path: Path, name: str) -> None:
    path.write_text(f"mtllib {name}\nusemtl a\nv 1 2 3\nv 1 2 4\nv 4 5 6\nf 1 2 3\n")


def named_by_vtp(path: Path, name: str) -> None:
    saved_mesh(path)
    whole = path.read_bytes()
    kinds = f'<!DOCTYPE VTKFile [<!ENTITY % e SYSTEM "{name}"> %e; <!ENTITY f SYSTEM "{name}">]>'
    path.write_bytes(
        whole.replace(b"<VTKFile", kinds.encode() + b"<VTKFile", 1).replace(
            b"<Points>", b"<Points>&f;"
        )
    )


def named_by_e57(path: Path, name: str) -> None:
    """Write a file with other XML; its pages end with checksums."""
    pye57 = pytest.importorskip("pye57")
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw({f"cartesian{axis}": np.arange(9.0) for axis in "XYZ"})
    whole = path.read_bytes()
    pages = b"".join(whole[start : start + 1020] for start in range(0, len(whole), 1024))
    place, length = struct.unpack_from("<QQ", whole, 24)
    place = place // 1024 * 1020 + place % 1024
    kinds = f'<!DOCTYPE e57Root SYSTEM "{name}"><e57Root'.encode()
    xml = pages[place : place + length].replace(b"<e57Root", kinds, 1)
    content = bytearray(pages[:place] + xml)
    content += bytes(-len(content) % 1020)
    struct.pack_into("<Q", content, 16, len(content) // 1020 * 1024)
    struct.pack_into("<Q", content, 32, len(xml))
    parts = (bytes(content[start : start + 1020]) for start in range(0, len(content), 1020))
    path.write_bytes(b"".join(part + checksum(part) for part in parts))


def checksum(page: bytes) -> bytes:
    """Return CRC-32C."""
    value = 0xFFFFFFFF
    for byte in page:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
    return (value ^ 0xFFFFFFFF).to_bytes(4, "big")


def named_by_gltf(path: Path, name: str) -> None:
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": name}],
        "images": [{"uri": name}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    path.write_text(json.dumps(document))


def named_by_dae(path: Path, name: str) -> None:
    """Write a mesh with an image and a document type."""
    trimesh.creation.box().export(path)
    image = f'<library_images><image id="i"><init_from>{name}</init_from></image></library_images>'
    text = path.read_text().replace("<library_geometries", f"{image}<library_geometries", 1)
    if name.startswith("file:"):
        kind = f'<!DOCTYPE a [<!ENTITY f SYSTEM "{name}">]><COLLADA'
        text = text.replace("<COLLADA", kind, 1).replace("<float_array", "&f;<float_array")
    path.write_text(text)


def named_by_3mf(path: Path, name: str) -> None:
    scene = trimesh.creation.box().scene()
    with zipfile.ZipFile(io.BytesIO(scene.export(file_type="3mf"))) as archive:
        parts = {info.filename: archive.read(info) for info in archive.infolist()}
    kind = f'<!DOCTYPE model [<!ENTITY f SYSTEM "{name}">]><model'.encode()
    with zipfile.ZipFile(path, "w") as archive:
        for part, content in parts.items():
            if part.endswith(".model"):
                content = content.replace(b"<model", kind, 1).replace(
                    b"<vertices>", b"<vertices>&f;"
                )
            archive.writestr(part, content)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
@pytest.mark.parametrize(
    ("suffix", "write"),
    [
        (".glb", named_by_glb),
        (".gltf", named_by_gltf),
        (".dae", named_by_dae),
        (".3mf", named_by_3mf),
        (".obj", named_by_obj),
        (".vtp", named_by_vtp),
        (".e57", named_by_e57),
    ],
)
@pytest.mark.parametrize("form", ["{0.name}", "{0}", "file://{0}"])
def test_a_file_does_not_lead_to_another(
    suffix: str, write: Callable[[Path, str], None], form: str, tmp_path: Path
) -> None:
    """The other file is a pipe that another process sees opened."""
    secret, path = tmp_path / "secret", tmp_path / f"a{suffix}"
    os.mkfifo(secret)
    write(path, form.format(secret))
    writer = subprocess.Popen([sys.executable, "-c", f"open({str(secret)!r}, 'w')"])
    try:
        code = (
            "import contextlib, neurbs\nwith contextlib.suppress(neurbs.NeurbsError):\n"
            f"    neurbs.read_points({str(path)!r})"
        )
        done = subprocess.run([sys.executable, "-c", code], timeout=60, cwd=tmp_path)
        assert done.returncode == 0
        assert writer.poll() is None, "the other file was opened"
    finally:
        writer.kill()
        writer.wait()
