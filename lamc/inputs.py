"""An old name of `lamc.records.inputs`, kept for programs that use it; what users need is in `lamc` itself."""

from lamc.basics.moved import moved

__getattr__ = moved("lamc.inputs", "lamc.records.inputs")
