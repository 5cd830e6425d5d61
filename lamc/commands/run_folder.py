"""Which folder the results of `lamc run` go to, so that no run takes the place of another design's or scene's unseen.

In: --out, the design, the scene's word. Out: a folder's path and a remark. It makes and writes nothing.
"""

import json
from itertools import count
from pathlib import Path
from typing import Any

from lamc.commands.inputs import Loaded, folder_name

MANIFEST = "manifest.json"
OWN = "scene"  # the folder of a design's own scene


def run_folder(out: str | None, loaded: Loaded, scene: str | None) -> tuple[str, str]:
    """The folder, and what to tell of it, or "".

    Without --out it is out/NAME/SCENE; where a run of another design of that name or of another scene is there,
    out/NAME/SCENE_2 and so on. With --out the folder is taken as it is, and the remark says what is replaced.
    """
    if out is not None:
        other = _other(Path(out), loaded, scene)
        return out, f"this run takes the place of {other} in {out}" if other else ""
    first = Path("out") / folder_name(loaded.name) / (folder_name(_scene_name(scene)) if scene else OWN)
    other = _other(first, loaded, scene)
    if not other:
        return str(first), ""
    for number in count(2):
        folder = first.with_name(f"{first.name}_{number}")
        if not _other(folder, loaded, scene):
            return str(folder), f"{first} holds {other}, so this run is in {folder}"
    raise AssertionError


def own_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of an earlier run in this folder; empty without one."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return manifest if isinstance(manifest, dict) and "lamc_version" in manifest else {}


def _scene_name(word: str) -> str:
    """Of "NAME", "FILE" or "FILE:NAME": NAME, the file's stem, or both."""
    file, colon, name = word.rpartition(":")
    return f"{Path(file).stem}_{name}" if colon and file else Path(word).stem or word


def _other(folder: Path, loaded: Loaded, scene: str | None) -> str:
    """What another design's or scene's run in this folder is of; empty where there is none."""
    manifest = own_manifest(folder)
    source = manifest.get("source")
    if not isinstance(source, str) or "scene" not in manifest:
        return ""
    before = manifest["scene"]
    if source != loaded.origin and Path(source).resolve() != Path(loaded.origin).resolve():
        return f"a run of {source}"
    if before != scene:
        return f"the scene {before!r}" if before is not None else "the design's own scene"
    return ""
