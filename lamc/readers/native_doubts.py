"""What a design's file says and may not mean: cuts that meet nothing, hinges that bend a board.

In: what was read of the file. Out: sentences for warnings. Never: refuses; changes what was read.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from lamc.readers.native_shapes import Region
from lamc.readers.schema import DesignModel


def vain_cuts(
    drawn_in: Sequence[Sequence[int]], regions: Sequence[Region | None], cuts: Sequence[bool]
) -> Iterator[tuple[int, str]]:
    """Cuts, by index, that meet nothing that was drawn before them in any of their layers, as of drawings whose y run
    opposite ways. drawn_in: for each layer the indices of what is drawn in it, or cut from it, ascending."""
    before: dict[int, list[Region]] = {
        k: [] for k, region in enumerate(regions) if cuts[k] and region is not None
    }
    after: dict[int, list[Region]] = {k: [] for k in before}
    for indices in dict.fromkeys(map(tuple, drawn_in)):
        drawn = [(k, each) for k in indices if not cuts[k] and (each := regions[k]) is not None]
        asked = [k for k in indices if k in before]
        if not asked or not drawn:
            continue
        tree = shapely.STRtree([each for _, each in drawn])
        which, met = tree.query([regions[k] for k in asked], predicate="intersects")
        for place, other in zip(which.tolist(), met.tolist(), strict=True):
            k, (first, each) = asked[place], drawn[other]
            if k in before and not shapely.touches(regions[k], each):
                if first < k:
                    del before[k], after[k]
                else:
                    after[k].append(each)
        for k in asked:
            if k in before:
                before[k] += [each for i, each in drawn if i < k]
    for k, shapes in before.items():
        region = regions[k]
        assert region is not None
        if after[k]:
            yield (
                k,
                f"the cut removes nothing: what lies in {_box(region)} is drawn after it; shapes are taken in their "
                "order, and a cut stands behind what it cuts",
            )
        elif shapes:
            yield (
                k,
                f"the cut removes nothing: it lies in {_box(region)}, and what was drawn before it in {_box(*shapes)}; "
                "in SVG y runs down the page, and is read as negative",
            )


def bending_board(model: DesignModel, index: int) -> str:
    """A sentence of a hinge in a layer, by index, that is rigid, where another one is to bend; else empty."""
    materials = [model.materials.get(layer.material) for layer in model.layers]
    chosen = materials[index]
    bends = [
        layer.name
        for layer, each in zip(model.layers, materials, strict=True)
        if each is not None and each.flexible
    ]
    if chosen is None or not chosen.rigid or chosen.flexible or not bends:
        return ""
    return (
        f"the hinge bends in layer {model.layers[index].name!r}, whose material is rigid: so much of a board bends as "
        f"film does; flexible {'is' if len(bends) == 1 else 'are'} {', '.join(map(repr, bends[:4]))}"
    )


def _box(*regions: Region) -> str:
    """Where they lie, in words."""
    x0, y0, x1, y1 = (1e3 * np.array(shapely.total_bounds(regions))).tolist()
    return f"x from {x0:.4g} to {x1:.4g} mm, y from {y0:.4g} to {y1:.4g} mm"
