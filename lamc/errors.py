"""An old name of `lamc.basics.errors`, kept for programs that use it; what users need is in `lamc` itself."""

from lamc.basics.moved import moved

__getattr__ = moved("lamc.errors", "lamc.basics.errors")
