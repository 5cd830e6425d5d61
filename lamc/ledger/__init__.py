"""What accuracy costs: work against precision, the account of effects, and a verdict, for any design in any scene.

In: a mechanism and a scene. Out: a `Ledger`, plain data. It draws and prints nothing.
"""

from lamc.ledger.measure import measure
from lamc.ledger.records import Ledger, Sweep

__all__ = ["Ledger", "Sweep", "measure"]
