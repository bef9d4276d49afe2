"""What one log alone says of its device: its posterior without the prior, as rows of a least-squares problem.

A result is a Gaussian N(mean, C), C^-1 = I + P^-1, where I is what the log told and P the prior about `initial`. Results of a
device share that prior, so their product would count it once a log. In units of the prior (C' = L^-1 C L^-T, P = LL') with
C' = V diag(c) V' the log's own information is V diag(1/c - 1) V', and its rows are sqrt(1/c - 1) V' L^-1: none for a direction that
the log did not tell.

Sigmas grow with noise_scale where the model fits badly, and the prior's share in them with it; 1/c - 1 then is too small by at
most 1 - 1/noise_scale^2 prior informations. It is never too large."""

import dataclasses

import numpy as np

LEAST_INFORMATION = 0.01  # of the prior's: below, a direction's sigma differs from the prior's by half a per cent, as much as rounding makes


@dataclasses.dataclass
class Evidence:
    """Rows R x = z about `initial`, each of unit variance; x over `names`."""
    names: list
    R: np.ndarray
    z: np.ndarray
    initial: np.ndarray
    prior: np.ndarray  # covariance, in printed parameters


def rotation_step(r):
    """J with Log(Exp(d) Exp(r)) = r + J d: the inverse of SO(3)'s left Jacobian (Sola et al., A micro Lie theory, eq. 146)."""
    angle = np.linalg.norm(r)
    K = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    if angle < 1e-6:
        return np.eye(3) - K / 2
    return np.eye(3) - K / 2 + (1 / angle**2 - 1 / (2 * angle * np.tan(angle / 2))) * K @ K


def prior_covariance(names, sigma, mean):
    """Of the printed parameters; `sigma` is that of small rotations where a name is a rotation vector's component."""
    J = np.eye(len(names))
    for i, name in enumerate(names):
        if name.endswith((".r_CI.x", ".r_AI.x")):
            J[i:i + 3, i:i + 3] = rotation_step(mean[i:i + 3])
    scaled = J * sigma
    return scaled @ scaled.T


def evidence_of(result):
    """None where the log's fit is no Gaussian about the truth: a failed one, or none at all."""
    parameters = result["parameters"]
    if result["status"] == "failed" or not parameters or not result.get("covariance"):
        return None
    names = [p["name"] for p in parameters]
    initial = np.array([p["initial"] for p in parameters])
    mean = np.array(result["mean"])
    C = np.array(result["covariance"]).reshape(len(names), len(names))
    P = prior_covariance(names, np.array([p["prior_sigma"] for p in parameters]), mean)
    L = np.linalg.cholesky(P)
    whitened = np.linalg.solve(L, np.linalg.solve(L, C).T)
    c, V = np.linalg.eigh((whitened + whitened.T) / 2)
    told = 1 / np.maximum(c, 1e-300) - 1
    keep = told > LEAST_INFORMATION
    root = np.sqrt(told[keep])
    offset = V[:, keep].T @ np.linalg.solve(L, mean - initial)  # of the posterior: it lies 1/c / (1/c - 1) nearer than the log's own
    R = root[:, None] * np.linalg.solve(L.T, V[:, keep]).T
    return Evidence(names, R, offset / c[keep] / root, initial, P)


def about(evidence, initial):
    """The same rows about another point."""
    return dataclasses.replace(evidence, z=evidence.z + evidence.R @ (evidence.initial - initial), initial=initial)
