"""`python -m lamc` is `lamc`."""

from lamc.cli import main

main()
