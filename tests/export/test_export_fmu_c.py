"""The sources of an FMU alone: other compilers, strict warnings, sanitizers, several FMUs in one program."""

import shutil
import zipfile
from functools import cache
from pathlib import Path

import pint
import pytest

import lamc
from lamc.export.fmu_units import BASE, base_units
from tests.support.ctools import cc, needs_cc, output_of
from tests.support.exported import C99, CXX17
from tests.support.fmus import VERSIONS, written

pytestmark = needs_cc

# 1000 instances: initialised, stepped, saved, put back, differentiated, refused, reset; with a count of memory.
DRIVER_2 = r"""
#include "model.h"
#include "fmi2Functions.h"
#include <stdio.h>
#include <stdlib.h>
static long held = 0, most = 0, sentences = 0;
static void *take(size_t count, size_t size) {
  if (++held > most) most = held;
  return calloc(count, size);
}
static void give(void *memory) { held -= memory != NULL; free(memory); }
static void hear(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...) {
  (void)e; (void)n; (void)s; (void)c; (void)m;
  ++sentences;
}
#define MUST(call) do { if ((call) != fmi2OK) { fprintf(stderr, "%s\n", #call); return 1; } } while (0)
int main(void) {
  const fmi2CallbackFunctions callbacks = {hear, take, give, NULL, NULL};
  const fmi2ValueReference angle = 1 + model_parameter_count + model_input_count, all = 2, mass = 1;
  for (int k = 0; k < 1000; ++k) {
    fmi2Real value, before, after, one = 1.0, none = NAN, slope;
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size;
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, MODEL_TOKEN, NULL, &callbacks, 0, 0);
    if (c == NULL || fmi2Instantiate("two", fmi2CoSimulation, "?", NULL, &callbacks, 0, 0) != NULL) return 1;
    MUST(fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2True, 1.0));
    MUST(fmi2EnterInitializationMode(c));
    MUST(fmi2ExitInitializationMode(c));
    MUST(fmi2DoStep(c, 0.0, 0.01, fmi2True));
    MUST(fmi2GetFMUstate(c, &state));
    MUST(fmi2DoStep(c, 0.01, 0.01, fmi2True));
    MUST(fmi2GetReal(c, &angle, 1, &before));
    MUST(fmi2SerializedFMUstateSize(c, state, &size));
    fmi2Byte *bytes = (fmi2Byte *)malloc(size);
    MUST(fmi2SerializeFMUstate(c, state, bytes, size));
    MUST(fmi2DeSerializeFMUstate(c, bytes, size, &copy));
    MUST(fmi2SetFMUstate(c, copy));
    MUST(fmi2GetFMUstate(c, &copy));
    MUST(fmi2DoStep(c, 0.01, 0.01, fmi2True));
    MUST(fmi2GetReal(c, &angle, 1, &after));
    if (before != after) return 1;
    MUST(fmi2GetDirectionalDerivative(c, &angle, 1, &angle, 1, &one, &slope));
    if (fmi2SetReal(c, &mass, 1, &none) != fmi2Error || fmi2DoStep(c, 0.5, 0.1, 1) != fmi2Error) return 1;
    if (fmi2DeSerializeFMUstate(c, bytes, 3, &copy) != fmi2Error) return 1;
    MUST(fmi2GetReal(c, &all, 1, &value));
    free(bytes);
    MUST(fmi2FreeFMUstate(c, &state));
    MUST(fmi2FreeFMUstate(c, &copy));
    MUST(fmi2Reset(c));
    fmi2FreeInstance(c);
  }
  printf("%ld %ld %ld\n", held, most, sentences);
  return 0;
}
"""
DRIVER_3 = r"""
#include "model.h"
#include "fmi3Functions.h"
#include <stdio.h>
#include <stdlib.h>
static long sentences = 0;
static void hear(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String m) {
  (void)e; (void)s; (void)c; (void)m;
  ++sentences;
}
#define MUST(call) do { if ((call) != fmi3OK) { fprintf(stderr, "%s\n", #call); return 1; } } while (0)
static fmi3Status step(fmi3Instance c, double t, double h) {
  fmi3Boolean event, end, early;
  fmi3Float64 reached;
  return fmi3DoStep(c, t, h, 1, &event, &end, &early, &reached);
}
static fmi3Instance make(const char *token) {
  return fmi3InstantiateCoSimulation("one", token, NULL, 0, 0, 0, 0, NULL, 0, NULL, hear, NULL);
}
int main(void) {
  const fmi3ValueReference angle = 1 + model_parameter_count + model_input_count, mass = 1;
  for (int k = 0; k < 1000; ++k) {
    fmi3Float64 before, after, one = 1.0, none = NAN, slope;
    fmi3FMUState state = NULL, copy = NULL;
    size_t size;
    fmi3Instance c = make(MODEL_TOKEN);
    if (c == NULL || make("?") != NULL) return 1;
    MUST(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 1, 1.0));
    MUST(fmi3ExitInitializationMode(c));
    MUST(step(c, 0.0, 0.01));
    MUST(fmi3GetFMUState(c, &state));
    MUST(step(c, 0.01, 0.01));
    MUST(fmi3GetFloat64(c, &angle, 1, &before, 1));
    MUST(fmi3SerializedFMUStateSize(c, state, &size));
    fmi3Byte *bytes = (fmi3Byte *)malloc(size);
    MUST(fmi3SerializeFMUState(c, state, bytes, size));
    MUST(fmi3DeserializeFMUState(c, bytes, size, &copy));
    MUST(fmi3SetFMUState(c, copy));
    MUST(step(c, 0.01, 0.01));
    MUST(fmi3GetFloat64(c, &angle, 1, &after, 1));
    if (before != after) return 1;
    MUST(fmi3GetDirectionalDerivative(c, &angle, 1, &angle, 1, &one, 1, &slope, 1));
    MUST(fmi3GetAdjointDerivative(c, &angle, 1, &angle, 1, &one, 1, &slope, 1));
    if (fmi3SetFloat64(c, &mass, 1, &none, 1) != fmi3Error || step(c, 0.5, 0.1) != fmi3Error) return 1;
    if (fmi3DeserializeFMUState(c, bytes, 3, &copy) != fmi3Error) return 1;
    if (fmi3EnterEventMode(c) != fmi3Error || fmi3SetTime(c, 0.0) != fmi3Error) return 1;
    free(bytes);
    MUST(fmi3FreeFMUState(c, &state));
    MUST(fmi3FreeFMUState(c, &copy));
    MUST(fmi3Reset(c));
    fmi3FreeInstance(c);
  }
  printf("0 0 %ld\n", sentences);
  return 0;
}
"""
SAID = {2: 4, 3: 6}  # refusals in each round of the drivers


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory):
    """sources(name, fmi) -> folder with the sources of an example's FMU."""
    examples = Path(lamc.__file__).parent / "examples"
    known: dict[tuple[str, int], Path] = {}

    def make(name: str, fmi: int) -> Path:
        if (name, fmi) not in known:
            simulator = lamc.compile(lamc.load(examples / f"{name}.yaml"))
            file = written(simulator, fmi, tmp_path_factory.mktemp(name))
            with zipfile.ZipFile(file) as archive:
                archive.extractall(file.with_suffix(""))
            known[name, fmi] = file.with_suffix("") / "sources"
        return known[name, fmi]

    return make


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.campaign
def test_a_thousand_instances_under_sanitizers(sources, fmi, tmp_path):
    folder = sources("five_bar", fmi)
    (tmp_path / "driver.c").write_text(DRIVER_2 if fmi == 2 else DRIVER_3)
    flags = [
        "-std=c99",
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "-Wall",
        "-Werror",
    ]
    inputs = ["driver.c", *map(str, (folder / f"fmi{fmi}.c", folder / "five_bar.c"))]
    cc(tmp_path, *flags, f"-I{folder}", *inputs, "-lm", "-o", "driver")
    held, most, sentences = map(int, output_of(tmp_path / "driver").split())
    assert held == 0
    assert most <= 4  # an instance, its name, two states
    assert sentences == 1000 * SAID[fmi]


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.parametrize("compiler", ["gcc", "clang", "g++"])
@pytest.mark.quick("*-3", others="campaign")
def test_sources_compile_without_a_warning(sources, fmi, compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"needs {compiler}")
    folder = sources("crawler", fmi)
    flags = CXX17 if compiler == "g++" else C99
    # The model's own C is held to the same with the exports of C.
    cc(tmp_path, *flags, "-c", str(folder / f"fmi{fmi}.c"), "-o", "unit.o", compiler=compiler)


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.slow
@pytest.mark.ci("3")
def test_two_fmus_in_one_program(sources, fmi, tmp_path):
    """Linked statically, with the prefixes that the standard's headers give to functions."""
    objects = []
    for name in ("five_bar", "crawler"):
        folder = sources(name, fmi)
        for unit, define in ((f"fmi{fmi}", f"-DFMI{fmi}_FUNCTION_PREFIX={name}_"), (name, "-DUNUSED")):
            objects.append(f"{name}_{unit}.o")
            cc(tmp_path, "-std=c99", define, "-c", str(folder / f"{unit}.c"), "-o", objects[-1])
    (tmp_path / "main.c").write_text(
        f"const char *five_bar_fmi{fmi}GetVersion(void);\nconst char *crawler_fmi{fmi}GetVersion(void);\n"
        f"int main(void) {{ return five_bar_fmi{fmi}GetVersion()[0] != crawler_fmi{fmi}GetVersion()[0]; }}\n"
    )
    cc(tmp_path, "main.c", *objects, "-lm", "-o", "both")
    assert output_of(tmp_path / "both") == ""


UNITS = (
    "rad", "rad/s", "rad/s²", "kg", "m", "kg·m²", "N·m", "N·m/rad", "N·m·s/rad", "N·m/rad^3", "N/m", "N·s/m", "J", "V",
    "Ω", "N·m/A", "N·m/V", "N/V", "m/s", "m/s²", "kg/m³", "1/s", "s/m", "A", "m/V", "s", "N*m", "1/(m·V)",
    "Hz", "C", "F", "H", "T", "mol/m³", "K",
)  # fmt: skip


@cache
def units_of_pint():
    return pint.UnitRegistry()


@pytest.mark.parametrize("unit", UNITS)
def test_base_units_are_those_of_pint(unit):
    """pint knows the same units; to it a radian is a number, to FMI a unit."""
    registry = units_of_pint()
    exponents = base_units(unit)
    assert exponents is not None
    assert set(exponents) <= set(BASE)
    text = (
        unit.replace("·", "*").replace("²", "**2").replace("³", "**3").replace("^", "**").replace("Ω", "ohm")
    )
    expected = registry.Quantity(1.0, text).to_base_units()
    product = registry.Quantity(1.0, "")
    for symbol, power in exponents.items():
        product *= registry.Quantity(1.0, symbol) ** power
    assert expected.to(product.units).magnitude == pytest.approx(1.0, rel=1e-12)  # SI: no factor
    radians = dict(registry.Quantity(1.0, text).unit_items()).get("radian", 0)
    assert exponents.get("rad", 0) == radians


def test_units_without_whole_exponents_have_no_definition():
    assert base_units("N/m^1.5") is None
    assert base_units("furlong") is None
    assert base_units("1") == {}
