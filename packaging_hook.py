"""Build hook: ships `templates/` and `runtime_c/` in the wheel as `lamc/_data/…`.

An editable install finds the two folders in the checkout (`lamc/basics/resources.py`), so they are added to
standard wheels only: a copy made at install time would go stale with the first edit.
"""

from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class DataHook(BuildHookInterface):
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "standard":
            build_data["force_include"]["templates"] = "lamc/_data/templates"
            build_data["force_include"]["runtime_c"] = "lamc/_data/runtime_c"
