"""Which configurations Zephyr takes segcal in, and whether Zephyr finds the module's samples and tests. Usage: test_kconfig.py MODULE"""

import pathlib
import re
import sys

from zephyr_stub import lines_of, load, module_yml, scenarios

MODULE = pathlib.Path(sys.argv[1])
GOOD = ["CONFIG_CPP=y", "CONFIG_STD_CPP17=y", "CONFIG_FPU=y", "CONFIG_SEGCAL=y"]
KEYS = {"name", "build", "samples", "tests"}  # of module.yml: Zephyr knows others, none of which is meant here


def check(condition, words):
    if not condition:
        sys.exit(words)


def values(lines, **board):
    loaded, wrong = load(MODULE, lines, **board)
    return {s.name: s.str_value for s in loaded.unique_defined_syms}, wrong


def taken(lines, **board):
    """Whether SEGCAL stays on, without a warning."""
    got, wrong = values(lines, **board)
    check((got["SEGCAL"] == "y") == (not wrong), f"{lines}, {board}: SEGCAL={got['SEGCAL']}, but {wrong}")
    return got["SEGCAL"] == "y"


def without(line, *instead):
    check(line in GOOD, line)
    return [*(other for other in GOOD if other != line), *instead]


def configurations():
    check(taken(GOOD), "the least that prj.conf must have")
    got, _ = values(GOOD)
    expected = {"REQUIRES_FULL_LIBCPP": "y", "GLIBCXX_LIBCPP": "y", "MINIMAL_LIBCPP": "n", "FPU_SHARING": "y", "SEGCAL_PORT": "y", "SEGCAL_PROFILE": "1",
                "SEGCAL_EIGEN_FOLDER": "/usr/include/eigen3"}
    check({name: got[name] for name in expected} == expected, f"{got} where {expected} is expected")
    check(taken(without("CONFIG_STD_CPP17=y", "CONFIG_STD_CPP20=y")), "C++20")
    for line in "CONFIG_STD_CPP17=y", "CONFIG_CPP=y", "CONFIG_FPU=y":
        check(not taken(without(line)), f"without {line}")
    for old in 98, 11, 14:
        check(not taken(without("CONFIG_STD_CPP17=y", f"CONFIG_STD_CPP{old}=y")), f"C++{old}")
    check(not taken(GOOD, STUB_CPU_HAS_FPU="n"), "a CPU without FPU")
    check(taken(without("CONFIG_FPU=y"), STUB_CPU_HAS_FPU="n", STUB_ARCH_POSIX="y"), "a PC")
    for profile, fits in ((1, True), (2, True), (3, True), (0, False), (4, False)):
        check((values([*GOOD, f"CONFIG_SEGCAL_PROFILE={profile}"])[1] == []) == fits, f"profile {profile}")
    off, _ = values(["CONFIG_CPP=y"])
    check("n" == off["SEGCAL"] == off["REQUIRES_FULL_LIBCPP"] and off["MINIMAL_LIBCPP"] == "y", "off, it changes nothing for others")


def applications():
    """Every application that twister finds below the folders of module.yml is complete, and each of its scenarios can be configured."""
    described, found = module_yml(MODULE), []
    check(set(described) == KEYS and (MODULE / described["build"]["cmake"] / "CMakeLists.txt").exists(), f"module.yml: {described}")
    for kind, file in (("samples", "sample.yaml"), ("tests", "testcase.yaml")):
        folders = [f.parent for root in described[kind] for f in (MODULE / root).rglob(file)]
        check(folders, f"no {file} below {described[kind]}")
        for folder in folders:
            for part in "CMakeLists.txt", "prj.conf", "src/main.c":
                check((folder / part).exists(), f"{folder} lacks {part}")
            for name, settings in scenarios(folder).items():
                _, wrong = load(MODULE, lines_of(folder, name))
                check(not wrong, f"{folder}, {name}: {wrong}")
                for overlay in settings.get("extra_dtc_overlay_files", []):
                    check((folder / overlay).exists(), f"{folder} lacks {overlay}")
                for pattern in settings.get("harness_config", {}).get("regex", []):
                    check(re.search(pattern, "profile 1, hash 0123456789abcdef") and not re.search(pattern, "profile 1, hash " + 16 * "0"), pattern)
                found.append(name)
    check(sorted(found) == ["sample.segcal.calibrate", "segcal.core", "segcal.storage"], f"scenarios: {found}")


configurations()
applications()
print("segcal in Zephyr's configurations; samples and tests: as documented")
