"""`segcal import` of the logs in fixtures/import, against what make_fixtures.py computed from the arrays that they were made of."""

import hashlib
import importlib.util
import json
import shutil
import unittest

import numpy as np

from support import SOURCE, Case, imu_of, images_of, main, pixels

FOLDER = SOURCE / "fixtures/import"
EXPECTED = json.loads((FOLDER / "expected.json").read_text())
LARGEST = 60_000, 400_000  # bytes of one log, of all: a clone stays small


def found(rec, with_images):
    """The recording in the terms of expected.json."""
    t_ns, _ = imu_of(rec)
    images = [(t, pixels(file)) for t, file in images_of(rec)] if with_images else []
    return {"samples": len(t_ns), "first_ns": int(t_ns[0]), "last_ns": int(t_ns[-1]),
            "imu_sha256": hashlib.sha256((rec / "mav0/imu0/data.csv").read_bytes()).hexdigest(),
            "images": [{"stamp_ns": t, "size": [image.shape[1], image.shape[0]], "bits": 8 * image.itemsize,
                        "sha256": hashlib.sha256(np.ascontiguousarray(image).tobytes()).hexdigest()} for t, image in images]}


class Frozen(Case):
    def test_each(self):
        for name, expected in EXPECTED.items():
            needs = expected.get("needs")
            with self.subTest(name):
                if needs and importlib.util.find_spec(needs) is None:
                    self.skipTest(f"no package {needs}")
                self.converted(*(FOLDER / file for file in expected["source"]))
                self.assertEqual(found(self.rec, bool(expected["images"])), {k: v for k, v in expected.items() if k not in ("source", "needs")})
                self.assertEqual((self.rec / "mav0/cam0").exists(), bool(expected["images"]))
            shutil.rmtree(self.rec, ignore_errors=True)

    def test_sizes(self):
        """Also that no log lies here which nobody expects anything of."""
        sizes = {}
        for file in FOLDER.rglob("*"):
            if file.is_file():
                log = file.relative_to(FOLDER).parts[0]
                sizes[log] = sizes.get(log, 0) + file.stat().st_size
        self.assertLess(max(sizes.values()), LARGEST[0], sizes)
        self.assertLess(sum(sizes.values()), LARGEST[1], sizes)
        named = {file.split("/")[0] for expected in EXPECTED.values() for file in expected["source"]}
        self.assertEqual(set(sizes) - {"expected.json"}, named)


if __name__ == "__main__":
    main()
