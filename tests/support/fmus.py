"""Exported FMUs as FMPy, which knows nothing of lamc, loads them; FMI 2.0 and 3.0 by one set of names."""

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from lamc.export.fmu import fmu_files
from lamc.export.options import ExportOptions
from lamc.run.simulator import Simulator

VERSIONS = (2, 3)


def need_fmpy() -> Any:
    """FMPy, or the test is skipped."""
    return pytest.importorskip("fmpy", reason="needs FMPy: pip install 'lamc[fmi]'")


def written(simulator: Simulator, fmi: int, folder: Path, **options: Any) -> Path:
    """The FMU of a simulator, as a file."""
    ((name, content),) = fmu_files(simulator, ExportOptions(fmi=fmi, **options)).items()
    path = folder / f"fmi{fmi}_{name}"
    path.write_bytes(content)
    return path


class Fmu:
    """One instance of an FMU, not yet initialised. `said` is what it logged: (status, category, message)."""

    def __init__(
        self, folder: Path, name: str = "one", token: str | None = None, said: list | None = None
    ) -> None:
        fmpy = need_fmpy()
        self.description = fmpy.read_model_description(str(folder))
        self.version = int(self.description.fmiVersion[0])
        self.by_name = {v.name: v for v in self.description.modelVariables}
        self.said: list[tuple[int, str, str]] = [] if said is None else said
        arguments = {
            "guid": token or self.description.guid,
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
            "unzipDirectory": str(folder),
            "instanceName": name,
        }
        if self.version == 2:
            self.fmu = self._instance_2(arguments)
        else:
            self.fmu = self._instance_3(arguments)

    def _instance_2(self, arguments: Mapping[str, str]) -> Any:
        from fmpy import calloc, fmi2, free

        def log(_environment: Any, _name: bytes, status: int, category: bytes, message: bytes) -> None:
            self.said.append((status, category.decode(), message.decode()))

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(log)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        fmu = fmi2.FMU2Slave(**arguments)
        fmu.instantiate(callbacks=callbacks)
        return fmu

    def _instance_3(self, arguments: Mapping[str, str]) -> Any:
        from fmpy import fmi3

        def log(_environment: Any, status: int, category: bytes, message: bytes) -> None:
            self.said.append((status, category.decode(), message.decode()))

        fmu = fmi3.FMU3Slave(**arguments)
        fmu.instantiate(logMessage=log)
        return fmu

    def renew(self) -> None:
        """Another instance of the same library, in place of this one."""
        if self.version == 2:
            self.fmu.instantiate(callbacks=self.fmu.callbacks)
        else:
            self.fmu.instantiate()

    def enter(self, stop: float | None = None, start: float = 0.0, tolerance: float | None = None) -> None:
        """Experiment, and into initialisation."""
        if self.version == 2:
            self.fmu.setupExperiment(tolerance=tolerance, startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=start, stopTime=stop)

    def begin(self, stop: float | None = None, start: float = 0.0, tolerance: float | None = None) -> "Fmu":
        """Through initialisation."""
        self.enter(stop, start, tolerance)
        self.fmu.exitInitializationMode()
        return self

    def references(self, names: Sequence[str]) -> list[int]:
        return [self.by_name[name].valueReference for name in names]

    def get(self, *names: str) -> list[float]:
        read = self.fmu.getReal if self.version == 2 else self.fmu.getFloat64
        return [float(x) for x in read(self.references(names))]

    def set(self, **values: float) -> None:
        self.put(values)

    def put(self, values: Mapping[str, float]) -> None:
        write = self.fmu.setReal if self.version == 2 else self.fmu.setFloat64
        write(self.references(list(values)), list(values.values()))

    def all_values(self) -> list[float]:
        return self.get(*self.by_name)

    def step(self, t: float, h: float) -> None:
        self.fmu.doStep(t, h)

    def walk(self, times: Sequence[float], *names: str) -> list[list[float]]:
        """Values of `names` at `times`, stepping from each to the next."""
        rows = [self.get(*names)]
        for t, after in pairwise(times):
            self.step(t, after - t)
            rows.append(self.get(*names))
        return rows

    def derivative(
        self, unknowns: Sequence[str], knowns: Sequence[str], seed: Sequence[float]
    ) -> list[float]:
        reported = self.fmu.getDirectionalDerivative(self.references(unknowns), self.references(knowns), seed)
        return [float(x) for x in reported]

    def free(self) -> None:
        """The instance, not the library, which other instances may use."""
        free = self.fmu.fmi2FreeInstance if self.version == 2 else self.fmu.fmi3FreeInstance
        free(self.fmu.component)

    @contextmanager
    def refusing(self, *words: str) -> Iterator[None]:
        """The block makes a call that is refused, with one message in the log that has these words."""
        from fmpy.fmi1 import FMICallException

        count = len(self.said)
        with pytest.raises(FMICallException) as caught:
            yield
        assert caught.value.status == 3  # fmi2Error, fmi3Error
        assert len(self.said) == count + 1
        status, category, message = self.said[-1]
        assert (status, category) == (3, "logStatusError")
        for word in words:
            assert word in message, message

    def function(self, name: str) -> Any:
        """A function of the library itself."""
        function = self.fmu.dll[name]  # not the one to which FMPy gave types
        function.restype = ctypes.c_int
        return function
