"""What all formats share after reading: choices, samples, images, calibration, and the account of it in import.json."""

import hashlib
import json
import sys

import numpy as np

import calibration
import imu_stage
from choose import Choice
from recording import CameraWriter, NewFolder, write_imu, write_noise
from streams import InputError

PROGRESS_IMAGES = 200
TRIGGER_NS = 100_000  # a device that turns by 2 rad/s moves its image by 0.1 px in this time


def file_hashes(paths):
    """sha256 of the source: of the file, or of names and hashes of the files of a folder."""
    out = []
    for path in paths:
        files = [path] if path.is_file() else sorted(f for f in path.rglob("*") if f.is_file())
        total = hashlib.sha256()
        for file in files:
            with file.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
            total.update(f"{file.relative_to(path) if path.is_dir() else ''}\0{digest}\n".encode())
        out.append({"path": path.name, "sha256": digest if path.is_file() else total.hexdigest(), "files": len(files)})
    return out


class Moments:
    """The stamps of cam0, which the other camera's images take over where the two differ by less than TRIGGER_NS: to all other commands images
    are of one moment if their stamps are equal."""

    def __init__(self, stamps):
        self.stamps = np.array(sorted(stamps), np.int64)
        self.moved = []

    def of(self, t_ns):
        if len(self.stamps) == 0:
            return t_ns
        at = int(np.searchsorted(self.stamps, t_ns))
        near = min((int(t) for t in self.stamps[max(0, at - 1) : at + 1]), key=lambda t: abs(t - t_ns))
        if near == t_ns or abs(near - t_ns) > TRIGGER_NS:
            return t_ns
        self.moved.append(abs(near - t_ns))
        return near


def copy_images(choice, names, folder, stamp_source, notes):
    """Images of each chosen camera to camN; what was written, by camera."""
    accounts = []
    moments = Moments([])
    for i, name in enumerate(names):
        writer = CameraWriter(folder / "mav0" / f"cam{i}")
        unstamped = 0
        try:
            for image in choice.owner[name].frames(name):
                t_ns = image.t_ns if stamp_source == "sensor" else image.log_ns
                if t_ns <= 0:
                    unstamped += 1
                    continue
                writer.add(moments.of(t_ns), image)
                if len(writer.names) % PROGRESS_IMAGES == 0:
                    print(f"{name}: {len(writer.names)} images", file=sys.stderr)
        except InputError as error:
            raise InputError(f"{error}" if str(error).startswith(choice.owner[name].where) else f"{choice.owner[name].where}: {name}: {error}") from None
        if not writer.names:
            why = "none has a stamp; --stamps log uses the time of logging" if unstamped else "there are none"
            raise InputError(f"{choice.owner[name].where}: {name}: expected images, but {why}")
        writer.finish()
        if moments.moved:
            notes.append(f"{name}: {len(moments.moved)} images have the stamps of {names[0]}'s, which differ by {max(moments.moved) * 1e-6:.2g} ms at most: one trigger")
        moments = Moments(writer.names)
        accounts.append({"stream": name, "images": len(writer.names), "size": list(writer.size), "dropped_same_stamp": writer.dropped,
                         "dropped_without_stamp": unstamped, "first_ns": min(writer.names), "last_ns": max(writer.names)})
    return accounts


def check_overlap(imu, cameras, stamp_source):
    first, last = int(imu.t_ns[0]), int(imu.t_ns[-1])
    for camera in cameras:
        if camera["last_ns"] < first or camera["first_ns"] > last:
            other = "log" if stamp_source == "sensor" else "sensor"
            raise InputError(f"{camera['stream']}: images from {camera['first_ns'] * 1e-9:.3f} s to {camera['last_ns'] * 1e-9:.3f} s, IMU from "
                             f"{first * 1e-9:.3f} s to {last * 1e-9:.3f} s: not one clock; try --stamps {other}")


def convert(sources, options):
    notes, warnings = [], []
    if options.calib and not options.calib.is_file():
        raise InputError(f"{options.calib}: no such file")
    choice = Choice(sources)
    with NewFolder(options.out) as folder:
        imu, stamp_source, dropped = imu_stage.prepared(choice, options, notes, warnings)
        names = choice.cameras(options.camera, notes)
        notes += [note for source in sources for note in getattr(source, "notes", [])]
        noise = calibration.noise_of(options, choice.owner[imu.name.split(' + ')[0]])
        imu_folder = folder / "mav0" / "imu0"
        write_imu(imu_folder, imu)
        rate_hz = 1e9 / float(np.median(np.diff(imu.t_ns)))
        write_noise(imu_folder, rate_hz, *noise)
        cameras = copy_images(choice, names, folder, stamp_source, notes)
        check_overlap(imu, cameras, stamp_source)
        chain = calibration.write(folder, choice, imu, names, cameras, (rate_hz, noise[0]), options, notes, warnings)
        if not names:
            warnings.append("no images: a recording for `segcal allan`; `segcal track` and `segcal replay` need images or tracks")
        if noise[1].startswith("assumed"):
            warnings.append("the IMU's noise is assumed; --imu-noise FILE states it, `segcal allan` measures it from a recording at rest")
        account = {
            "format": 1,
            "sources": file_hashes(options.sources),
            "source_format": [source.title for source in sources],
            "stamps": stamp_source,
            "imu": {"stream": imu.name, "samples": len(imu.t_ns), "rate_hz": rate_hz, "first_ns": int(imu.t_ns[0]),
                    "last_ns": int(imu.t_ns[-1]), "dropped_in_merging": dropped, "noise": noise[1]},
            "cameras": cameras,
            "calibration": chain,
            "notes": notes,
            "warnings": warnings,
        }
        (folder / "import.json").write_text(json.dumps(account, indent=2) + "\n")
    for line in notes:
        print(f"note: {line}", file=sys.stderr)
    for line in warnings:
        print(f"warning: {line}", file=sys.stderr)
    if options.json:
        print(json.dumps(account, indent=2))
    else:
        print(summary(options.out, account))


def summary(out, account):
    imu = account["imu"]
    seconds = (imu["last_ns"] - imu["first_ns"]) * 1e-9
    lines = [f"{out}: {imu['samples']} IMU samples of {imu['stream']}, {imu['rate_hz']:.1f} Hz, {seconds:.1f} s"]
    for i, camera in enumerate(account["cameras"]):
        lines.append(f"  cam{i}: {camera['images']} images {camera['size'][0]} x {camera['size'][1]} of {camera['stream']}")
    if account["cameras"] and account["calibration"]:
        lines.append(f"next: segcal track {out}, then segcal replay {out} --out OUT")
    return "\n".join(lines)
