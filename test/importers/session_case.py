"""The output of a replay and its recording, to be exported for a viewer."""

import numpy as np
from support import Case, segcal

RNG = np.random.default_rng(11)


class SessionCase(Case):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"
        for arguments in (("simulate", "--out", self.rec, "--scenario", "rich", "--seconds", 8, "--seed", 1),
                          ("replay", self.rec, "--segments", 2, "--segment-seconds", 3, "--out", self.out)):
            done = segcal(*arguments)
            self.assertIn(done.returncode, (0, 1), done.stderr)
        camera = self.rec / "mav0/cam0"
        (camera / "data").mkdir()
        self.stamp = int((camera / "tracks.csv").read_text().splitlines()[1].split(",")[0])
        self.picture = RNG.bytes(500)  # carried as it is: an MCAP writer does not look into it
        (camera / "data/a.png").write_bytes(self.picture)
        (camera / "data.csv").write_text(f"#timestamp [ns],filename\n{self.stamp},a.png\n")
