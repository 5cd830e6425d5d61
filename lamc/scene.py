"""An old name of `lamc.records.scene`, kept for programs that use it; what users need is in `lamc` itself."""

from lamc.basics.moved import moved

__getattr__ = moved("lamc.scene", "lamc.records.scene")
