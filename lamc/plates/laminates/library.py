"""Materials whose numbers are printed somewhere.

Out: `LIBRARY`, by name, and `material(name)`; `source` of each says where its numbers stand. Never: a number that is
in no source: an expansion that is not given counts as zero, a strength or a modulus through the thickness as unknown.

Boards and adhesives differ by maker, humidity and time under load by more than a table can tell; the one of each that
is here shows the order of magnitude. Measure yours, and give it as a Material: a strip that sags under its own weight
is enough. Acrylic tapes are not here, as they creep: under a lasting load no modulus describes them.
"""

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.basics.readonly import ReadOnlyDict
from lamc.plates.laminates.materials import Material

_TSAI_HAHN = "S. W. Tsai and H. T. Hahn, Introduction to Composite Materials, 1980"
_DANIEL_ISHAI = (
    "I. M. Daniel and O. Ishai, Engineering Mechanics of Composite Materials, 2nd ed. 2006, table A.4"
)
_ERTURK_INMAN = (
    "A. Erturk and D. J. Inman, Piezoelectric Energy Harvesting, 2011, table E.1, at constant field"
)

_FIBRES = (
    Material(
        E1=181e9,
        E2=10.3e9,
        nu12=0.28,
        G12=7.17e9,
        density=1600.0,
        alpha1=0.02e-6,
        alpha2=22.5e-6,
        beta2=0.6,
        Xt=1500e6,
        Xc=1500e6,
        Yt=40e6,
        Yc=246e6,
        S=68e6,
        name="T300/5208",
        source=f"{_TSAI_HAHN}: carbon fibre in epoxy, 70 % fibres by volume",
    ),
    Material(
        E1=126e9,
        E2=11e9,
        nu12=0.28,
        G12=6.6e9,
        density=1600.0,
        alpha1=-1e-6,
        alpha2=26e-6,
        G13=6.6e9,
        G23=11e9 / (2 * (1 + 0.4)),  # E2 and nu23 = 0.4: isotropic across the fibres
        Xt=1950e6,
        Xc=1480e6,
        Yt=48e6,
        Yc=200e6,
        S=79e6,
        name="AS4/3501-6",
        source=(
            "P. D. Soden, M. J. Hinton and A. S. Kaddour, Composites Science and Technology 58 (1998) 1011: carbon "
            f"fibre in epoxy, 60 % fibres by volume; density {_DANIEL_ISHAI}"
        ),
    ),
    Material(
        E1=294e9,
        E2=6.4e9,
        nu12=0.23,
        G12=4.9e9,
        density=1590.0,
        Xt=985e6,
        Xc=690e6,
        Yt=29e6,
        Yc=98e6,
        S=49e6,
        name="GY-70/934",
        source=f"{_DANIEL_ISHAI}: carbon fibre of high modulus in epoxy, 57 % fibres by volume",
    ),
    Material(
        E1=38.6e9,
        E2=8.27e9,
        nu12=0.26,
        G12=4.14e9,
        density=1800.0,
        alpha1=8.6e-6,
        alpha2=22.1e-6,
        beta2=0.6,
        Xt=1062e6,
        Xc=610e6,
        Yt=31e6,
        Yc=118e6,
        S=72e6,
        name="Scotchply 1002",
        source=f"{_TSAI_HAHN}: E-glass in epoxy, 45 % fibres by volume",
    ),
)
_SHEETS = (
    Material.isotropic(
        E=2.5e9,
        nu=0.34,
        density=1420.0,
        alpha=20e-6,
        name="Kapton HN",
        source="DuPont, Kapton HN data sheet: polyimide film at 23 °C",
    ),
    Material.isotropic(
        E=4.9e9,
        nu=0.38,
        density=1390.0,
        alpha=17e-6,
        name="Mylar",
        source=(
            "DuPont Teijin Films, Mylar physical-thermal properties, H-37232-3: polyester (PET) film; E is the mean of "
            "490 and 510 kgf/mm² along and across the web"
        ),
    ),
    Material.isotropic(
        E=210e9,
        nu=0.3,
        density=7850.0,
        alpha=12e-6,
        name="steel",
        source="EN 1993-1-1:2005, 3.2.6; density EN 1993-1-2:2005, 3.2.2",
    ),
    Material.isotropic(
        E=70e9,
        nu=0.3,
        density=2700.0,
        alpha=23e-6,
        name="aluminium",
        source="EN 1999-1-1:2007, 3.2.5",
    ),
)
_BOARDS_AND_ADHESIVES = (
    Material(
        E1=7.44e9,
        E2=3.47e9,
        nu12=0.15 * 7.44 / 3.47,
        G12=2.04e9,
        density=780.0,
        G13=0.137e9,
        G23=0.099e9,
        name="paperboard",
        source=(
            "R. W. Mann, G. A. Baum and C. C. Habeger, Tappi 63(2), 1980: carton stock, 1 along the machine's "
            "direction, by ultrasound, so stiffer than under slow loads; their 0.15 is taken as nu21, with which G12 "
            "is sqrt(E1 E2) / 2 (1 + sqrt(nu12 nu21)), as it is for other papers"
        ),
    ),
    Material.isotropic(
        E=1.11e9,
        nu=0.34,
        density=1214.0,  # 0.060 lb/ft² over 9.5 mil
        name="AF 163-2K",
        source=(
            "3M, Scotch-Weld AF 163-2 data sheet: epoxy film adhesive on a knit carrier, cured, at 24 °C; density from "
            "its weight of 0.060 lb/ft² and thickness of 9.5 mil before cure"
        ),
    ),
)


def _ceramic(
    name: str, s11: float, s12: float, s66: float, s55: float, d31: float, density: float
) -> Material:
    """A ceramic poled upwards, from compliances in 1/TPa and d31 in pm/V as they are printed."""
    return Material(
        E1=1e12 / s11,
        E2=1e12 / s11,
        nu12=-s12 / s11,
        G12=1e12 / s66,
        density=density,
        d31=1e-12 * d31,
        d32=1e-12 * d31,
        G13=1e12 / s55,
        G23=1e12 / s55,
        name=name,
        source=_ERTURK_INMAN,
    )


_PIEZO = (
    _ceramic("PZT-5A", 16.4, -5.74, 44.3, 47.5, -171.0, 7750.0),
    _ceramic("PZT-5H", 16.5, -4.78, 42.6, 43.5, -274.0, 7500.0),
)

LIBRARY: ReadOnlyDict[str, Material] = ReadOnlyDict(
    {m.name: m for m in (*_FIBRES, *_SHEETS, *_BOARDS_AND_ADHESIVES, *_PIEZO)}
)


def material(name: str) -> Material:
    """The material of that name in `LIBRARY`. Raises DesignError with the names there are."""
    if name not in LIBRARY:
        raise DesignError(
            f"there is no material {shown(name)} in the library; there are {', '.join(sorted(LIBRARY))}: "
            "choose one, or give Material(E1=…, E2=…, nu12=…, G12=…, density=…)"
        )
    return LIBRARY[name]
