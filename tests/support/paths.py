"""Folders of the checkout that tests read."""

from pathlib import Path

TESTS = Path(__file__).resolve().parent.parent
ROOT = TESTS.parent
FIXTURES = TESTS / "fixtures"
GOLDEN = TESTS / "golden"
CORTEX = TESTS / "cortex"
RUNTIME = ROOT / "runtime_c"
