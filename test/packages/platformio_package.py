"""The library as a package of PlatformIO: packed and checked by PlatformIO Core as for its registry, installed from the archive by an example
project, built by Core's own builder. Usage, with the Python that has PlatformIO and SCons (host_tools/setup.sh makes one):
platformio_package.py TREE EIGEN_FOLDER WORK_FOLDER. Prints what the program prints; the log is WORK_FOLDER/log.

Nothing is loaded from PlatformIO's registry. What Core would load from there is here in other ways: SCons from PyPI; the platform `native`, a
few lines that name gcc (native_platform); the list of licences, of which the package names one."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

from platformio.dependencies import get_core_dependencies
from platformio.package.manifest.schema import ManifestSchema
from platformio.package.pack import PackagePacker

TREE, EIGEN, WORK = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3]).resolve()
NEEDED, UNWANTED = {"library.json", "LICENSE", "lib/include/segcal/segcal.h", "port/include/segcal/port.h"}, ("test/", "fixtures/", "host_tools/", "build/")


def stand_in(kind, name, version, folder):
    """Makes `folder` what Core takes for installed from its registry."""
    spec = {"owner": "platformio", "id": None, "name": name, "requirements": None, "uri": None}
    (folder / ".piopm").write_text(json.dumps({"type": kind, "name": name, "version": version, "spec": spec}))


def core_folder():
    core = WORK / "core"
    native, scons = core / "platforms/native", core / "packages/tool-scons"
    shutil.copytree(pathlib.Path(__file__).with_name("native_platform"), native)
    stand_in("platform", "native", json.loads((native / "platform.json").read_text())["version"], native)
    scons.mkdir(parents=True)
    version = get_core_dependencies()["tool-scons"].removeprefix("~")
    (scons / "package.json").write_text(json.dumps({"name": "tool-scons", "version": version}))
    (scons / "scons.py").write_text("import SCons.Script\nSCons.Script.main()\n")
    stand_in("tool", "tool-scons", version, scons)
    return core


def packed():
    ManifestSchema.load_spdx_licenses = staticmethod(lambda: {"licenses": [{"licenseId": "BSD-3-Clause"}]})
    archive = PackagePacker(TREE).pack(str(WORK / "segcal.tar.gz"))
    names = subprocess.run(["tar", "tzf", archive], check=True, capture_output=True, text=True).stdout.split()
    missing, too_much = NEEDED - set(names), [n for n in names if n.startswith(UNWANTED)]
    if missing or too_much:
        sys.exit(f"the package lacks {sorted(missing)} and has {too_much[:5]}")
    return archive


def main():
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    environment = {**os.environ, "PLATFORMIO_CORE_DIR": str(core_folder()), "PLATFORMIO_WORKSPACE_DIR": str(WORK / "workspace"),
                   "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no", "PLATFORMIO_SETTING_CHECK_PLATFORMIO_INTERVAL": "9999", "PLATFORMIO_NO_ANSI": "1",
                   "SEGCAL_PACKAGE": f"file://{packed()}", "EIGEN_FOLDER": EIGEN}
    project = pathlib.Path(TREE) / "examples/packages/platformio"
    done = subprocess.run([sys.executable, "-B", "-m", "platformio", "run", "--verbose", "--jobs", "2", "--project-dir", project], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    (WORK / "log").write_text(done.stdout)
    if done.returncode != 0:
        sys.exit(done.stdout[-4000:])
    return subprocess.run([WORK / "workspace/build/native/program"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
