"""Records to tables, one Parquet file each. Rows are in the order of the logs and hold nothing of when or where the work was done, so
that the same logs give the same files, byte for byte; times.parquet holds the rest."""

import pathlib

import pyarrow as pa
import pyarrow.parquet as pq
from output_run import OutputRun, write_whole

TEXT, WHOLE, REAL, FLAG = pa.string(), pa.int64(), pa.float64(), pa.bool_()

SCHEMAS = {
    "runs": {"key": TEXT, "log": TEXT, "device": TEXT, "model": TEXT, "place": WHOLE, "status": TEXT, "cause": TEXT, "exit_code": WHOLE,
             "error": TEXT, "log_sha256": TEXT, "library_version": TEXT, "result_hash": TEXT, "start_ns": WHOLE, "end_ns": WHOLE,
             "segments": WHOLE, "segments_kept": WHOLE, "chi2": REAL, "dof": REAL, "noise_scale": REAL, "iterations": WHOLE,
             "image_points": WHOLE, "reprojection_rms_px": REAL, "lowest_degC": REAL, "highest_degC": REAL},
    "parameters": {"key": TEXT, "device": TEXT, "model": TEXT, "place": WHOLE, "name": TEXT, "unit": TEXT, "value": REAL, "sigma": REAL,
                   "initial": REAL, "prior_sigma": REAL, "verdict": TEXT, "mean": REAL, "fused": REAL},
    "effects": {"key": TEXT, "device": TEXT, "name": TEXT, "unit": TEXT, "value": REAL, "sigma": REAL, "verdict": TEXT},
    "information": {"key": TEXT, "device": TEXT, "names": pa.list_(TEXT), "rows": WHOLE, "R": pa.list_(REAL), "z": pa.list_(REAL)},
    "segments": {"key": TEXT, "device": TEXT, "session": WHOLE, "start_ns": WHOLE, "end_ns": WHOLE, "keyframes": WHOLE, "landmarks": WHOLE,
                 "A": REAL, "D": REAL, "E": REAL, "rank": WHOLE, "gain_nats": REAL, "kept": FLAG, "outdated": FLAG},
    "faults": {"key": TEXT, "device": TEXT, "name": TEXT, "count": WHOLE},
    "devices": {"device": TEXT, "model": TEXT, "name": TEXT, "unit": TEXT, "value": REAL, "sigma": REAL, "initial": REAL, "prior_sigma": REAL,
                "logs": WHOLE, "from_place": WHOLE, "at_degC": REAL, "distance_sigma": REAL},
    "changes": {"device": TEXT, "model": TEXT, "block": TEXT, "form": TEXT, "or_form": TEXT, "from_place": WHOLE, "from_log": TEXT,
                "statistic": REAL, "log10_p": REAL, "name": TEXT, "unit": TEXT, "step": REAL, "rate": REAL, "rate_unit": TEXT, "sigma": REAL},
    "models": {"model": TEXT, "name": TEXT, "unit": TEXT, "mean": REAL, "mean_sigma": REAL, "spread": REAL, "prior_sigma": REAL, "devices": WHOLE},
    "attention": {"rank": WHOLE, "device": TEXT, "log": TEXT, "kind": TEXT, "weight": REAL, "sentence": TEXT},
    "times": {"key": TEXT, "log": TEXT, "begun": REAL, "seconds": REAL, "host": TEXT, "vio_ms_median": REAL, "vio_ms_p95": REAL,
              "score_ms_median": REAL, "calibrate_ms": REAL},
}
SENSORS = ("cam", "gyro.", "accel.")  # what a parameter of theta begins with; all else is an effect's


def is_effect(name):
    return not name.startswith(SENSORS)


def run_row(run):
    result = run.record["result"] or {}
    fit, segments = result.get("fit", {}), result.get("segments", [])
    low, high = result.get("temperature_degC") or (None, None)
    return {**run.identity(), "log": run.log, "status": result.get("status", "refused"), "cause": result.get("cause"),
            "exit_code": run.record["exit_code"], "error": run.record["error"] or None, "log_sha256": result.get("log_sha256"),
            "library_version": result.get("library_version"), "result_hash": result.get("result_hash"),
            "start_ns": min((s["start_ns"] for s in segments), default=None), "end_ns": max((s["end_ns"] for s in segments), default=None),
            "segments": len(segments), "segments_kept": sum(s["kept"] for s in segments), "lowest_degC": low, "highest_degC": high,
            **{name: fit.get(name) for name in ("chi2", "dof", "noise_scale", "iterations", "image_points", "reprojection_rms_px")}}


def rows_of_runs(runs):
    """The tables that are a sum over logs."""
    out = {name: [] for name in ("runs", "parameters", "effects", "information", "segments", "faults", "times")}
    for run in runs:
        out["runs"].append(run_row(run))
        out["times"].append({"key": run.key, "log": run.log, **run.record.get("times", {})})
        result, identity = run.record["result"] or {}, run.identity()
        for i, p in enumerate(result.get("parameters", [])):
            mean = result["mean"][i] if result.get("mean") else None
            out["effects" if is_effect(p["name"]) else "parameters"].append({**identity, **p, "mean": mean})
        out["segments"] += [{**identity, **s} for s in result.get("segments", [])]
        out["faults"] += [{**identity, "name": n, "count": c} for n, c in result.get("faults", {}).items()]
        if run.evidence:
            e = run.evidence
            out["information"].append({**identity, "names": e.names, "rows": len(e.z), "R": e.R.ravel().tolist(), "z": e.z.tolist()})
    return out


def table(name, rows):
    schema = pa.schema(list(SCHEMAS[name].items()))
    columns = {field.name: pa.array([row.get(field.name) for row in rows], field.type) for field in schema}
    return pa.table(columns, schema=schema)


def write_tables(fs, root, rows):
    """All of them belong together: manifest.json says so at the end."""
    with OutputRun(fs, root, "fleet", [f"{name}.parquet" for name in SCHEMAS]):
        for name in SCHEMAS:
            write_whole(fs, f"{root}/{name}.parquet", lambda file, name=name: pq.write_table(table(name, rows.get(name, [])), file, compression="zstd"))


def last_part(log):
    return pathlib.Path(log).name
