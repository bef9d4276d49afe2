"""From the logs' evidence to devices, models, and what a person should look at."""

import dataclasses

import numpy as np

import change_words
import evidence
import forms
import fusion
import logs
import population
import problem
import tables

WORST = 10  # logs that a report shows


@dataclasses.dataclass
class Run:
    """One log of the fleet."""
    key: str
    log: str
    record: dict
    device: str
    model: str
    place: int = 0                 # among the logs of its device
    evidence: object = None        # evidence.Evidence, or None

    def identity(self):
        return {"key": self.key, "device": self.device, "model": self.model, "place": self.place}

    def told(self):
        """Whether the log says anything of theta."""
        return self.evidence is not None and len(self.evidence.z) > 0

    def chi2_per_dof(self):
        fit = (self.record["result"] or {}).get("fit", {})
        return fit["chi2"] / fit["dof"] if fit.get("dof", 0) > 0 else None


def runs_of(entries, store, pattern):
    """`entries` of work.run_batch, in the order of the logs."""
    runs, count = [], {}
    for entry in entries:
        record = store.read(entry["key"])
        device, model = logs.device_of(entry["log"], record["result"], pattern)
        run = Run(entry["key"], entry["log"], record, device, model, count.get(device, 0))
        count[device] = run.place + 1
        run.evidence = evidence.evidence_of(record["result"]) if record["result"] else None
        runs.append(run)
    return runs


def grouped(runs, attribute):
    groups = {}
    for run in runs:
        groups.setdefault(getattr(run, attribute), []).append(run)
    return groups


@dataclasses.dataclass
class Fused:
    device: str
    model: str
    runs: list                     # those with evidence, as the fit took them
    fit: fusion.Device
    units: list
    axes: forms.Axes
    distance: dict = dataclasses.field(default_factory=dict)   # by parameter, sigmas from its model


def axes_of(runs):
    results = [r.record["result"] for r in runs]
    starts = [min((s["start_ns"] for s in result.get("segments", [])), default=None) for result in results]
    return forms.axes_of(starts, [r.place for r in runs], [result.get("temperature_degC") for result in results])


def fuse_devices(runs):
    """Devices that have any evidence, and the dispersion between logs of a device."""
    groups = []
    for device, own in sorted(grouped([r for r in runs if r.evidence], "device").items()):
        names = own[0].evidence.names
        own = [r for r in own if r.evidence.names == names]
        groups.append((device, own, fusion.common([r.evidence for r in own]), axes_of(own)))
    fits, dispersion = fusion.fuse_fleet([rows for _, _, rows, _ in groups], [axes for _, _, _, axes in groups])
    return [Fused(device, own[0].model, own, fit, [p["unit"] for p in own[0].record["result"]["parameters"]], axes)
            for (device, own, _, axes), fit in zip(groups, fits)], dispersion


def since(d, block):
    """Index of the first log of which the fused value is true: after the last step, and of a trend the last log alone."""
    own = [c.form for c in d.fit.changes if c.block == block]
    return len(d.runs) - 1 if any(f.kind == forms.TREND for f in own) else max((f.first for f in own), default=0)


def device_rows(fused):
    rows = []
    for d in fused:
        sigma, prior = np.sqrt(np.diag(d.fit.covariance)), np.sqrt(np.diag(d.fit.prior))
        warm = {c.block for c in d.fit.changes if c.form.kind == forms.TEMPERATURE}
        for i, name in enumerate(d.fit.names):
            block = problem.block_of(name)
            rows.append({"device": d.device, "model": d.model, "name": name, "unit": d.units[i], "value": d.fit.value[i], "sigma": sigma[i],
                         "initial": d.fit.initial[i], "prior_sigma": prior[i], "logs": len(d.runs),
                         "from_place": d.runs[since(d, block)].place, "at_degC": d.axes.reference_degC() if block in warm else None,
                         "distance_sigma": d.distance.get(name)})
    return rows


def add_fused(rows, fused):
    """To each log's parameters: the device's value at that log, by all logs."""
    at = {(d.device, run.place, name): value for d in fused for k, run in enumerate(d.runs) for name, value in zip(d.fit.names, d.fit.at(k))}
    for row in (*rows["parameters"], *rows["effects"]):
        row["fused"] = at.get((row["device"], row["place"], row["name"]))


def outlier_limit(fused):
    return population.limit_of(max(1, sum(len(d.fit.names) for d in fused)))


def model_rows(fused):
    """Mean and spread per model and parameter; fills in the devices' distances."""
    rows = []
    limit = outlier_limit(fused)
    for model in sorted({d.model for d in fused}):
        of_model = [d for d in fused if d.model == model and d.fit.names == next(f for f in fused if f.model == model).fit.names]
        names = of_model[0].fit.names
        for i, name in enumerate(names):
            x = np.array([d.fit.value[i] for d in of_model])
            sigma = np.array([np.sqrt(d.fit.covariance[i, i]) for d in of_model])
            prior = np.array([np.sqrt(d.fit.prior[i, i]) for d in of_model])
            spread, far = population.spread_of(x, sigma, sigma < 0.5 * prior, limit)
            for d, distance in zip(of_model, far):
                d.distance[name] = None if np.isnan(distance) else float(distance)
            if spread:
                rows.append({"model": model, "name": name, "unit": of_model[0].units[i], "mean": spread.mean, "mean_sigma": spread.sigma,
                             "spread": spread.spread, "prior_sigma": float(np.hypot(spread.spread, spread.sigma)), "devices": spread.devices})
    return rows


def found(kind, weight, device, log, sentence):
    return {"kind": kind, "weight": float(weight), "device": device, "log": log, "sentence": sentence}


def outliers(fused):
    """Devices away from their model, but for those that a change explains: they are named for that."""
    limit = outlier_limit(fused)
    for d in fused:
        changed = {c.block for c in d.fit.changes}
        judged = ((n, abs(v)) for n, v in d.distance.items() if v is not None and problem.block_of(n) not in changed)
        name, distance = max(judged, key=lambda x: x[1], default=("", 0))
        if distance > limit:
            yield found("outlier", distance, d.device, d.runs[-1].log, f"{name} is {d.distance[name]:+.1f} sigmas from the other devices of its model")


def badly_fitting(runs):
    """Devices whose logs fit the model worse than those of the other devices, whatever the fit was judged."""
    tests = len({r.device for r in runs})
    for model, own in sorted(grouped(runs, "model").items()):
        devices = sorted(grouped([r for r in own if r.chi2_per_dof()], "device").items())
        ratios = [np.median([r.chi2_per_dof() for r in of_device]) for _, of_device in devices]
        for i, excess in population.badly_fitting(ratios, tests):
            worst = max(devices[i][1], key=Run.chi2_per_dof)
            yield found("misfit", 10 * excess, devices[i][0], worst.log,
                        f"chi2/dof {ratios[i]:.2f}, {excess:.1f} times its model's: another lens, or an effect that the model lacks (segcal diagnose)")


def silent(runs):
    """Devices of which hardly a log gives a result, although others of the model do: odometry that does not even start, or fits that fail."""
    tests = len({r.device for r in runs})
    for model, own in sorted(grouped([r for r in runs if r.record["result"]], "model").items()):
        devices = sorted(grouped(own, "device").items())
        without = [[r for r in of_device if not r.told()] for _, of_device in devices]
        for i in population.silent([len(of_device) for _, of_device in devices], [len(w) for w in without], tests):
            device, of_device = devices[i]
            causes = [(r.record["result"].get("cause") or "the fit failed").split(":")[0] for r in without[i]]
            usual = max(sorted(set(causes)), key=causes.count)
            yield found("misfit", 10 * len(without[i]) / len(of_device), device, without[i][0].log,
                        f"{len(without[i])} of {len(of_device)} logs gave no result, unlike its model's other devices: another lens or mounting? Most often: {usual}")


def one_a_device(findings):
    """The gravest of each device."""
    return list({f["device"]: f for f in sorted(findings, key=lambda f: f["weight"])}.values())


def attention(fused, runs):
    """What to look at, the gravest first: changes, outliers and misfits of devices, then logs that gave nothing."""
    all_found = [*outliers(fused), *one_a_device([*badly_fitting(runs), *silent(runs)])]
    for d in fused:
        for c in d.fit.changes:
            all_found.append(found("change", np.sqrt(c.statistic), d.device, change_words.log_of(d, c), change_words.sentence(d, c)))
    misfits = {f["device"] for f in all_found if f["kind"] == "misfit"}
    for run in runs:
        share = 0.5 if run.device in misfits else 1  # what its logs say, the device's own row says for all of them
        if run.record["result"] is None:
            all_found.append(found("refused", 3, run.device, run.log, run.record["error"]))
        elif run.record["result"]["status"] == "failed":
            all_found.append(found("failed", 4 * share, run.device, run.log, run.record["result"].get("cause") or "the fit did not settle or does not match its noise"))
        elif run.record["result"]["status"] == "insufficient":
            all_found.append(found("insufficient", share, run.device, run.log, run.record["result"].get("cause") or "the motion told too little"))
    all_found.sort(key=lambda a: (-a["weight"], a["device"], a["log"]))
    return [{"rank": i + 1, **a} for i, a in enumerate(all_found)]


def rows_of_fleet(runs):
    """All tables' rows, and the dispersion between logs of a device."""
    fused, dispersion = fuse_devices(runs)
    rows = tables.rows_of_runs(runs)
    rows["models"] = model_rows(fused)
    rows["devices"] = device_rows(fused)
    rows["changes"] = [row for d in fused for row in change_words.rows_of(d)]
    add_fused(rows, fused)
    rows["attention"] = attention(fused, runs)
    return rows, dispersion
