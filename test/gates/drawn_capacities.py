"""Capacities drawn from a stated range: the core compiles with each, and SEGCAL_STORAGE_BYTES is enough and wastes little (the checks of the
library itself). Usage: drawn_capacities.py CXX EIGEN_FOLDER SOURCE_TREE [SETS [SEED]]

Of the first set every function is compiled too, the others are the layout alone: a second against ten."""

import random
import subprocess
import sys

CXX, EIGEN, SOURCE = sys.argv[1:4]
SETS, SEED = (int(a) for a in (sys.argv[4:] + ["16", "1"][len(sys.argv) - 4:])[:2])
WHOLE = 1
OPTIONS = ["-std=c++17", "-fsyntax-only", "-DEIGEN_DONT_VECTORIZE", "-DEIGEN_NO_MALLOC", "-DEIGEN_NO_IO", "-DEIGEN_DONT_PARALLELIZE", "-DEIGEN_NO_DEBUG",
           "-fno-exceptions", "-fno-rtti", f"-I{SOURCE}/lib/src", f"-I{SOURCE}/lib/include", f"-I{SOURCE}/port/include", "-isystem", EIGEN]


def draw(rng):
    landmarks = rng.randint(20, 200)
    return {"PROFILE": 1, "MAX_CAMERAS": rng.randint(1, 2), "MAX_SEGMENTS": rng.randint(1, 24), "MAX_KEYFRAMES": rng.randint(6, 32), "MAX_LANDMARKS": landmarks,
            "MAX_OBSERVATIONS": rng.randint(6, 14) * landmarks, "MAX_IMU_SAMPLES": rng.randint(300, 4500), "MAX_CLONES": rng.randint(6, 31),
            "MAX_TRACKS": rng.randint(20, 200), "MAX_TIES": rng.choice([0, 4, 8]), "IMU_HISTORY": rng.randint(200, 2000), "PIXEL_BITS": rng.choice([16, 32]),
            "MAX_EFFECT_COLUMNS": rng.choice([0, 1, 3, 12]), "TRACK_WALK": rng.randint(0, 1), "FRAME_FEATURES": rng.randint(4, 30), "REAL": rng.choice(["float", "float", "double"]),
            "KEEP_ELIMINATIONS": rng.randint(0, 1)}


rng = random.Random(SEED)
failed = 0
for i in range(SETS):
    capacities = [f"-DSEGCAL_{name}={value}" for name, value in draw(rng).items()]
    for file in ["memory.cpp", "device.cpp"][:2 if i < WHOLE else 1]:
        done = subprocess.run([CXX, *OPTIONS, *capacities, f"{SOURCE}/lib/src/api/{file}"], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            failed += 1
            print(file, *capacities, *(line for line in done.stderr.splitlines() if "error" in line or "reduces" in line), sep="\n  ")
print(f"{SETS} sets drawn from {SEED}, {failed} do not compile")
sys.exit(failed > 0)
