"""Reconstruct real terrain.

    python examples/terrain.py

Reads ``jacksboro.xyz`` beside this script and writes ``jacksboro.step``, ``jacksboro.obj`` and
``jacksboro.png`` to the current folder.
"""

from pathlib import Path

import neurbs


def main() -> None:
    """Reconstruct, print the report and write the files."""
    points = neurbs.read_point_cloud(Path(__file__).with_name("jacksboro.xyz"))
    result = neurbs.reconstruct(points)
    print(result.report)
    for suffix in ("step", "obj", "png"):
        result.save(f"jacksboro.{suffix}")


if __name__ == "__main__":
    main()
