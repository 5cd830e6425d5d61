"""The verbs of the command line: one module each, called by `lamc.cli` with plain arguments and a `Terminal`."""
