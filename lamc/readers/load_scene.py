"""`load_scene`: a scene from a file of scenes, or from the scenes of a design file.

In: a path, and a name where the file has several. Out: a `Scene`. Nothing in a file is ever executed.
"""

import os
from pathlib import Path

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place
from lamc.readers.checking import Problems, did_you_mean, validate
from lamc.readers.fields import LENGTH_UNIT
from lamc.readers.inert import DEFAULT_LIMITS, STANDARD_TAGS, Limits, MapNode, Node, ScalarNode, compose
from lamc.readers.load import file_text, load_text
from lamc.readers.native import length_unit_of
from lamc.readers.scene_file import Scenes, read_scenes
from lamc.readers.scene_schema import LoneSceneModel, SceneFileModel
from lamc.records.scene import Scene

_OF_DESIGNS = ("layers", "shapes", "materials", "bodies", "joints", "hinges")


def load_scene(path: Path | str, name: str | None = None, *, limits: Limits = DEFAULT_LIMITS) -> Scene:
    """The scene in the file at `path`: the one of that name; without a name its `scene:`, or the only one it has.

    The file is one scene (effects, angles, …), or has `scene:` and `scenes:`, as design files may have too.
    limits  what the file may cost; a file beyond them is refused with the limit's name

    Raises DesignError (DesignErrors for several problems) for a file that is missing, unreadable or malformed, and for
    a name that it does not have.
    """
    if not isinstance(path, str | os.PathLike):
        raise DesignError(f"the path is {shown(path)}; it must be a string or a pathlib.Path")
    if name is not None and not isinstance(name, str):
        raise DesignError(f"the name of a scene is {shown(name)}; it must be a string, or None")
    return scene_of_text(file_text(path, limits), str(path), name, limits=limits)


def scene_of_text(text: str, file: str, name: str | None = None, *, limits: Limits = DEFAULT_LIMITS) -> Scene:
    """The scene in a text; messages call it `file`. Raises as `load_scene` does."""
    try:
        node = compose(text, file, limits=limits)
        if _is_design(node):
            record = load_text(text, file, limits=limits)
            scenes = Scenes(record.scene, record.scenes)
        else:
            scenes = _read(node)
    except RecursionError as error:
        raise DesignError("the file nests too deeply to be read", Place(file)) from error
    return _chosen(scenes, file, name)


def _chosen(scenes: Scenes, file: str, name: str | None) -> Scene:
    known = list(scenes.named)
    if name is not None:
        if name not in scenes.named:
            raise DesignError(
                f"no scene of the file is named {name[:40]!r}; {did_you_mean(name, known)}", Place(file)
            )
        return scenes.named[name]
    if scenes.default is not None:
        return scenes.default
    if len(known) == 1:
        return scenes.named[known[0]]
    if not known:
        raise DesignError("the file has no scene; give it one under scene: or scenes:", Place(file))
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    raise DesignError(f"the file has the scenes {listed}; say which, as in {file}:{known[0]}", Place(file))


def _is_design(node: Node) -> bool:
    """True for what `load` should read; all else is read, and refused, as scenes."""
    if not isinstance(node, MapNode) or node.tag not in STANDARD_TAGS:
        return True
    kind = node.get("kind")
    if isinstance(kind, ScalarNode):
        return kind.text != "scene"
    return any(node.get(key) is not None for key in _OF_DESIGNS)


def _read(node: Node) -> Scenes:
    """The scenes of a file that has nothing else. Raises DesignErrors with every problem."""
    assert isinstance(node, MapNode)
    bare = length_unit_of(node)
    problems = Problems(node)
    if node.get("scene") is not None or node.get("scenes") is not None:
        model = validate(SceneFileModel, node, {LENGTH_UNIT: bare})
        scenes = read_scenes(model.scene, model.scenes, problems, bare)
    else:
        lone = validate(LoneSceneModel, node, {LENGTH_UNIT: bare})
        scenes = read_scenes(lone, {}, problems, bare, at=())
    problems.raise_if_any()
    return scenes
