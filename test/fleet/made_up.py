"""Results of logs whose truth is known: each a Gaussian with its own directions. For tests that import host_tools/fleet."""

import evidence
import numpy as np

NAMES = [f"cam0.{p}" for p in "r_CI.x r_CI.y r_CI.z p_CI.x p_CI.y p_CI.z fx fy cx cy w".split()]
NAMES += [f"{s}.{p}" for s in ("gyro", "accel") for p in "sx sy sz mx my mz".split()] + [f"accel.r_AI.{a}" for a in "xyz"]
SIGMA = np.array([.05] * 3 + [.03] * 3 + [10] * 4 + [.03] * 7 + [.05] * 9)
INITIAL = np.array([1.0, 1.2, -1.2, 0, 0, 0, 256, 256, 320, 240, .92] + [0] * 15)
N = len(NAMES)


def result_of(truth, random, noise_scale=1.0):
    """What a log of such a device would say: some directions told a hundred times better than the prior, some not at all."""
    P = evidence.prior_covariance(NAMES, SIGMA, truth)
    half = np.linalg.inv(np.linalg.cholesky(P))
    V = np.linalg.qr(random.normal(size=(N, N)))[0]
    root = 10 ** random.uniform(-2, 2.5, N) * (random.uniform(size=N) > 0.2)
    rows = root[:, None] * (half.T @ V).T
    information = rows.T @ rows
    C = np.linalg.inv(information + half.T @ half)
    mean = INITIAL + C @ (information @ (truth - INITIAL) + rows.T @ (noise_scale * random.normal(size=N)))
    C *= noise_scale**2
    parameters = [{"name": n, "initial": INITIAL[i], "prior_sigma": SIGMA[i]} for i, n in enumerate(NAMES)]
    return {"status": "calibrated", "mean": list(mean), "covariance": list(C.ravel()), "parameters": parameters}


def drawn(random):
    return INITIAL + 0.3 * np.linalg.cholesky(evidence.prior_covariance(NAMES, SIGMA, INITIAL)) @ random.normal(size=N)
