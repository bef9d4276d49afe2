"""Stand-in for the part of Zephyr's build that reads module.yml, Kconfig, prj.conf and a scenario of sample.yaml or testcase.yaml.
Usage: zephyr_stub.py MODULE APPLICATION SCENARIO OUT. Writes OUT/config.cmake and OUT/autoconf.h; a warning is an error."""

import os
import pathlib
import sys
import tempfile

import kconfiglib
import yaml

TOP = pathlib.Path(__file__).with_name("Kconfig")
BOARD = {"STUB_CPU_HAS_FPU": "y", "STUB_ARCH_POSIX": "n"}


def module_yml(module):
    return yaml.safe_load((module / "zephyr/module.yml").read_text(encoding="utf-8"))


def scenarios(application):
    """Name -> its settings, with those of `common`."""
    file = next(f for f in (application / "sample.yaml", application / "testcase.yaml") if f.exists())
    described = yaml.safe_load(file.read_text(encoding="utf-8"))
    return {name: {**described.get("common", {}), **own} for name, own in described["tests"].items()}


def lines_of(application, scenario):
    return (application / "prj.conf").read_text(encoding="utf-8").splitlines() + scenarios(application)[scenario].get("extra_configs", [])


def load(module, lines, **board):
    """What these lines of a prj.conf give with the module, and what is wrong with them: names that are not there, values that do not hold."""
    os.environ.update({**BOARD, **board}, STUB_MODULE_KCONFIG=str(module / module_yml(module)["build"]["kconfig"]))
    loaded = kconfiglib.Kconfig(str(TOP), warn_to_stderr=False)
    loaded.warn_assign_undef = True
    with tempfile.NamedTemporaryFile("w", suffix=".conf") as file:
        file.write("\n".join(lines) + "\n")
        file.flush()
        loaded.load_config(file.name)
    values = {symbol.name: symbol.str_value for symbol in loaded.unique_defined_syms}
    wrong = list(loaded.warnings)
    for line in lines:
        name, _, value = line.removeprefix("CONFIG_").partition("=")
        if line.startswith("CONFIG_") and values.get(name) != value.strip('"'):
            wrong.append(f"{name} was given {value} and is {values.get(name)}")
    return loaded, wrong


def main():
    module, application, scenario, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3], pathlib.Path(sys.argv[4])
    loaded, wrong = load(module, lines_of(application, scenario))
    if wrong:
        sys.exit("\n".join(wrong))
    out.mkdir(parents=True, exist_ok=True)
    loaded.write_autoconf(str(out / "autoconf.h"))
    settings = [f'set(CONFIG_{s.name} "{s.str_value}")' for s in loaded.unique_defined_syms if s.str_value not in ("n", "")]
    settings.append(f"set(STUB_MODULE_CMAKE {(module / module_yml(module)['build']['cmake']).as_posix()})")
    (out / "config.cmake").write_text("\n".join(settings) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
