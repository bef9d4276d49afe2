"""Fusion, changes and outliers on made-up results whose truth is known: each log a Gaussian with its own directions.
A failing case prints its seed:  test_fusion.py SOURCE_TREE [SEED]"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(sys.argv[1]) / "host_tools" / "fleet"))
import evidence  # noqa: E402
import fusion  # noqa: E402
import population  # noqa: E402
import problem  # noqa: E402
import search  # noqa: E402
from made_up import INITIAL, NAMES, SIGMA, drawn, result_of  # noqa: E402

SEED = int(sys.argv[2]) if len(sys.argv) > 2 else 1


def device(truth, random, count, **how):
    return fusion.common([evidence.evidence_of(result_of(truth, random, **how)) for _ in range(count)])


def between(what, low, value, high):
    assert low <= value <= high, f"{what}: {value:.4g} is not in [{low}, {high}]; seed {SEED}"


def test_fused_sigmas_are_honest(random):
    """40 devices, 6 logs each: 1040 squares of standard normals, correlated; 1 +- 0.1 is about two sigmas if half were independent.
    One log alone, without fusion, is as honest; fusing must also be narrower, or it took one log only."""
    squares, narrower, named = [], [], 0
    for _ in range(40):
        truth = drawn(random)
        logs = device(truth, random, 6)
        one, all_six = fusion.fuse(logs[:1]), fusion.fuse(logs, tests=40 * search.tests_of(logs))
        sigma = np.sqrt(np.diag(all_six.covariance))
        squares.append(np.mean(((all_six.value - truth) / sigma) ** 2))
        narrower.append(np.median(sigma / np.sqrt(np.diag(one.covariance))))
        named += len(all_six.changes)
    between("mean of (error / sigma)^2", 0.85, np.mean(squares), 1.15)
    between("sigma of six logs over sigma of one", 0, np.median(narrower), 0.25)  # each tells other directions
    assert named == 0, f"{named} changes named in devices that did not; seed {SEED}"


def test_prior_counts_once(random):
    """Fifty logs that tell nothing leave the prior as it was."""
    nothing = result_of(INITIAL, random)
    nothing["covariance"] = list(evidence.prior_covariance(NAMES, SIGMA, INITIAL).ravel())
    nothing["mean"] = list(INITIAL)
    fused = fusion.fuse(fusion.common([evidence.evidence_of(nothing)] * 50))
    np.testing.assert_allclose(fused.covariance, fused.prior, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(fused.value, INITIAL, atol=1e-12)


def test_step_is_found_in_its_place(random):
    for block, size in (("cam0.r_CI", 0.04), ("gyro.scale", 0.03), ("cam0.focal length and centre", 15.0)):
        old = drawn(random)
        new = old.copy()
        chosen = problem.indices(NAMES, block)
        new[chosen[0]] += size
        fused = fusion.fuse(device(old, random, 5) + device(new, random, 4))
        assert [(c.form.kind, c.form.first, c.block) for c in fused.changes] == [("step", 5, block)], f"{block}: {fused.changes}; seed {SEED}"
        step = fused.changes[0]
        far = (step.value - (new - old)[chosen]) / np.sqrt(np.diag(step.covariance))
        between(f"{block}: step, error / sigma", 0, np.abs(far).max(), 4)
        now = (fused.value - new) / np.sqrt(np.diag(fused.covariance))
        between(f"{block}: value after the step, mean square of error / sigma", 0, np.mean(now**2), 2.5)


def test_dispersion(random):
    """Logs three times noisier than they say, but for two devices of twenty that changed: 9 times chi-square, and no change invented."""
    devices = [device(drawn(random), random, 5) for _ in range(20)]
    for logs in devices:
        for log in logs:
            log.z = log.z + np.sqrt(8) * random.normal(size=len(log.z))
    ratio = fusion.dispersion_of([problem.solve(logs, []) for logs in devices])
    between("dispersion", 7.2, ratio, 10.8)  # a median of 20 ratios with 65 degrees of freedom each: four sigmas
    tests = sum(map(search.tests_of, devices))
    assert not any(fusion.fuse(logs, ratio, tests).changes for logs in devices)
    assert any(fusion.fuse(logs, 1.0, tests).changes for logs in devices), "without it, changes are invented: else this shows nothing"


def test_population(random):
    """A model's spread within 3 sigmas of what was drawn (its own is 1/sqrt(2 n)), one device far off named and left out."""
    sigma = random.uniform(0.2, 1.0, 60)
    x = 10 + 2.0 * random.normal(size=60) + sigma * random.normal(size=60)
    x[7] += 20
    spread, far = population.spread_of(x, sigma, np.ones(60, bool), population.limit_of(60))
    assert list(np.flatnonzero(np.abs(far) > population.limit_of(60))) == [7], f"{far}; seed {SEED}"
    between("spread", 2 * (1 - 3 / np.sqrt(120)), spread.spread, 2 * (1 + 3 / np.sqrt(120)))
    between("mean, error / sigma", -4, (spread.mean - 10) / spread.sigma, 4)
    assert spread.devices == 59
    same = population.spread_of(10 + sigma * random.normal(size=60), sigma, np.ones(60, bool), 4)[0]
    between("spread of equal devices", 0, same.spread, 0.5)  # sigmas of 0.5: spread^2 is uncertain by 0.5^2 sqrt(2/60), five times that


def test_level(random):
    """400 fleets of ten equal devices each: named in 1 % of them, and 8 at most by chance (binomial, 5 sigma is 14). As if the spread
    of ten devices were known, it would be in 5 % of them."""
    limit, named = population.limit_of(10), 0
    for _ in range(400):
        far = population.spread_of(random.normal(size=10), np.full(10, 0.01), np.ones(10, bool), limit)[1]
        named += (np.abs(far) > limit).any()
    between("fleets with a device named", 0, named, 14)


def test_silent():
    logs = [20] * 50
    without = [0] * 50
    for i in (5, 6, 7):
        without[i] = 20
    assert population.silent(logs, without, 50) == [5, 6, 7]
    assert population.silent(logs, [1, 2, 0, 3, 1] * 10, 50) == []  # 7 % everywhere, by the motion
    assert population.silent([20] * 4, [20, 0, 0, 0], 4) == []      # of four, none is the rule


def test_misfits():
    ratios = [1.0, 1.02, 0.99, 1.01, 0.98, 1.03, 4.0, 1.3]
    assert [i for i, _ in population.badly_fitting(ratios, len(ratios))] == [6]
    assert population.badly_fitting([1, 9], 2) == []  # of two, neither is the rule


for number, test in enumerate([test_fused_sigmas_are_honest, test_prior_counts_once, test_step_is_found_in_its_place, test_dispersion, test_population, test_level]):
    test(np.random.default_rng([SEED, number]))
test_misfits()
test_silent()
print("fusion: honest, changes in their place, spread as drawn")
