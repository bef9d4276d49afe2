"""Whether a device was one and the same all the time, and if not, what of it changed in which form.

Of all changes, each block in each form, the one that is least likely by chance is taken if that is beyond the level, then the next: forward
selection, as the core's own test for outdated segments divides by the noise that the logs show among themselves. A trend looks like
several steps as long as it is not taken; so after each one that is added the earlier ones are chosen anew (looked_back)."""

import dataclasses
import math

import numpy as np
from scipy.stats import chi2

import forms
from problem import Change, block_of, gains, indices, solve

LEVEL = 1e-2        # probability that a fleet without any change has one named
MOST_CHANGES = 8    # of one device; more is a device that never holds still
MOST_LOOKS = 4      # back, after each change that is added; two do nearly always
TOLD_APART = 2 * math.log(20)  # difference of cost between two forms at odds of 20 to 1, which were alike before the logs


def log10_chance(statistic, dof):
    """log10 of the probability that chi-square with `dof` degrees of freedom is larger; far out, where it is no number any more, by the
    first term of the incomplete gamma function's expansion (Abramowitz and Stegun, 6.5.32)."""
    chance = chi2.sf(statistic, dof)
    if chance > 1e-300:
        return math.log10(chance)
    half = statistic / 2
    return (-half + (dof / 2 - 1) * math.log(half) - math.lgamma(dof / 2)) / math.log(10)


@dataclasses.dataclass
class Search:
    """What is looked at in a device. `tests`: how many are in the whole fleet."""
    logs: list
    forms: list
    dispersion: float
    tests: int

    def blocks(self):
        return list(dict.fromkeys(map(block_of, self.logs[0].names)))

    def each(self, changes, blocks):
        """Each further change of these blocks that the logs would show."""
        base, names = solve(self.logs, changes), self.logs[0].names
        courses, sigma = np.array([form.course for form in self.forms]), np.sqrt(np.diag(self.logs[0].prior))
        for block in blocks:
            chosen = indices(names, block)
            for form, gain, told in zip(self.forms, *gains(base, chosen, sigma[chosen], courses)):
                if told:
                    statistic = float(gain) / self.dispersion
                    yield Change(form, block, statistic, min(0.0, log10_chance(statistic, told) + math.log10(self.tests)))

    def best(self, changes, blocks=None):
        """The most significant further change, or None."""
        best = min(self.each(changes, blocks or self.blocks()), key=lambda c: c.log10_p, default=None)
        return best if best and best.log10_p < math.log10(LEVEL) else None

    def looked_back(self, changes, blocks=None):
        """Each is taken out, and what is best in its place, if anything, beside the others put there, until that changes nothing."""
        for _ in range(MOST_LOOKS):
            before = changes
            for old in before:
                others = [c for c in changes if c is not old]
                again = self.best(others, blocks)
                changes = [*others, again] if again else others
            if len(changes) == len(before) and all(a.same(b) for a, b in zip(changes, before)):
                break
        return changes

    def rivals(self, change, changes):
        """The best of each other form of the block that in its place would leave the cost almost as low."""
        best = {}
        for other in self.each([c for c in changes if c is not change], [change.block]):
            kind = other.form.kind
            if kind != change.form.kind and other.statistic > max(change.statistic - TOLD_APART, best.get(kind, (0,))[0]):
                best[kind] = other.statistic, other.form
        return [form for _, form in best.values()]

    def grown(self, changes, blocks=None):
        """With what is beyond chance beside them, one by one, of these blocks."""
        seen = []
        while self.forms and len(changes) < MOST_CHANGES and (further := self.best(changes, blocks)):
            changes = self.looked_back([*changes, further], blocks)
            now = {(c.block, c.form.kind, c.form.first) for c in changes}
            if now in seen or len(seen) == 2 * MOST_CHANGES:  # in a circle, or lost
                break
            seen.append(now)
        return changes

    def price(self, changes):
        """The cost, and for each change what it must take off to be beyond chance."""
        lengths = (len(indices(self.logs[0].names, c.block)) for c in changes)
        return solve(self.logs, changes).cost / self.dispersion + sum(chi2.isf(LEVEL / self.tests, n) for n in lengths)


def begun_otherwise(search, blocks):
    """What is found where a block is asked first, beginning with a form that is not a step, or with none. A trend with a step back looks
    like many steps of many blocks, and no single one of these is better replaced."""
    smooth = [form for form in search.forms if form.kind != forms.STEP]
    for block in blocks:
        for begin in ([], *([Change(form, block, 0.0, 0.0)] for form in smooth)):
            yield search.looked_back(search.grown(search.grown(begin, [block])))


def changes_of(search):
    found = search.grown([])
    if len(found) > 1:
        found = min([found, *begun_otherwise(search, dict.fromkeys(c.block for c in found))], key=search.price)
    for change in found:
        change.rivals = search.rivals(change, found)
    return sorted(found, key=lambda c: c.log10_p)


def tests_of(logs, axes=None):
    """One for each block and form."""
    return len(forms.forms_of(axes or forms.places_alone(len(logs)))) * len(set(map(block_of, logs[0].names)))
