"""Which streams become the recording's IMU and cameras: what the user named, else what is obvious, else a question."""

import re

from checks import accel_unit
from streams import InputError


def listing(streams):
    return ", ".join(f"{s.name} ({s.kind}, {s.count})" for s in streams) or "nothing that can be used"


def calibrated(streams):
    """Without those named uncalibrated, where others are left."""
    return [s for s in streams if "uncalib" not in s.name.lower()] or streams


NO_PICTURE = re.compile(r"depth|disparity|confidence|segmentation", re.IGNORECASE)
COMPRESSED = re.compile(r"/compressed$")


def pictures(streams, notes):
    """Without distances (depth cameras publish them as images), and without the compressed copy of a stream that is there raw, where others
    are left."""
    names = {s.name for s in streams}
    twins = [s for s in streams if COMPRESSED.search(s.name) and COMPRESSED.sub("", s.name) in names]
    left = [s for s in streams if s not in twins]
    left = [s for s in left if not NO_PICTURE.search(s.name)] or left
    notes += [f"{s.name}: not taken, {'the same images as ' + COMPRESSED.sub('', s.name) if s in twins else 'by its name no picture'}; --camera NAME takes it"
              for s in streams if s not in left]
    return left


def first_choices(streams, option, notes):
    """Without those that a format sets aside, where others are left."""
    left = [s for s in streams if not s.aside] or streams
    notes += [f"{s.name}: not taken, {s.aside}; {option} NAME takes it" for s in streams if s not in left]
    return left


class Choice:
    """Streams of all sources by name; a name is what --list shows."""

    def __init__(self, sources):
        self.sources = sources
        self.owner, self.streams = {}, []
        for source in sources:
            for stream in source.streams():
                if stream.count > 0 and stream.kind != "other":
                    if stream.name in self.owner:
                        raise InputError(f"{source.where}: its stream {stream.name} is in {self.owner[stream.name].where} as well: expected logs of different "
                                         "names of streams, or one at a time")
                    self.owner[stream.name] = source
                    self.streams.append(stream)

    def of_kind(self, *kinds):
        return [s for s in self.streams if s.kind in kinds]

    def named(self, name, option, *kinds):
        if name not in [s.name for s in self.of_kind(*kinds)]:
            raise InputError(f"{option} {name}: no such stream; found {listing(self.of_kind(*kinds))}")
        return name

    def cameras(self, wanted, notes):
        if len(wanted) > 2 or len(set(wanted)) < len(wanted):
            raise InputError(f"--camera {' --camera '.join(wanted)}: expected one stream or two different ones, cam0 first")
        if wanted:
            return [self.named(name, "--camera", "camera") for name in wanted]
        found = first_choices(pictures(self.of_kind("camera"), notes), "--camera", notes)
        if len(found) > 2:
            raise InputError(f"{len(found)} cameras, segcal takes two at most: choose with --camera NAME; found {listing(found)}")
        return [s.name for s in found]

    def imu(self, options, notes):
        """(samples with both sensors, None, None) or (None, gyroscope's, accelerometer's)."""
        if options.gyro or options.accel:
            if not (options.gyro and options.accel):
                raise InputError("--gyro NAME and --accel NAME belong together")
            pick = [self.read(self.named(name, option, "imu", kind))
                    for name, option, kind in ((options.gyro, "--gyro", "gyro"), (options.accel, "--accel", "accel"))]
            return self.both(*pick)
        if options.imu:
            imu = self.read(self.named(options.imu, "--imu", "imu"))
            if imu.gyro is None or imu.accel is None:
                raise InputError(f"--imu {options.imu}: no {'rotation rates' if imu.gyro is None else 'accelerations'} in it; give --gyro and --accel")
            return imu, None, None
        return self.obvious_imu(notes)

    def obvious_imu(self, notes):
        read = [self.read(s.name) for s in first_choices(self.of_kind("imu", "gyro", "accel"), "--imu", notes)]
        whole = [imu for imu in read if imu.gyro is not None and imu.accel is not None]
        if len(whole) == 1:
            return whole[0], None, None
        if len(whole) > 1:
            raise InputError(f"{len(whole)} IMUs: choose with --imu NAME; found {', '.join(imu.name for imu in whole)}")
        gyros = calibrated([i for i in read if i.gyro is not None])
        accels = [i for i in read if i.accel is not None]
        # Applications log acceleration with and without gravity; only the raw one is of use.
        accels = calibrated([i for i in accels if accel_unit(i.accel)] or accels)
        if len(gyros) == 1 and len(accels) == 1:
            return self.both(gyros[0], accels[0])
        if gyros and accels:
            raise InputError(f"choose with --gyro NAME and --accel NAME; found {listing(self.of_kind('imu', 'gyro', 'accel'))}")
        raise InputError(f"{self.sources[0].where}: no gyroscope and accelerometer in it; found {listing(self.streams)} (segcal import --list shows all that is inside)")

    def both(self, gyro, accel):
        for imu, values, what in ((gyro, gyro.gyro, "rotation rates"), (accel, accel.accel, "accelerations")):
            if values is None:
                raise InputError(f"{imu.name}: no {what} in this stream")
        return None, gyro, accel

    def read(self, name):
        return self.owner[name].imu(name)
