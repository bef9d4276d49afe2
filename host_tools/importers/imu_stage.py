"""From the IMU streams of a log to the samples of a recording: stamps, merging, units, axes. What was done is noted."""

import numpy as np

import checks
import merge
import stamps
from streams import InputError


def with_stamps(imu, choice, notes):
    """Uses `choice` ("sensor" or "log") as stamps; sorts what came out of order."""
    imu.t_ns = imu.t_ns if choice == "sensor" else imu.log_ns
    order = np.argsort(imu.t_ns, kind="stable")
    if np.any(np.diff(imu.t_ns) < 0):
        notes.append(f"{imu.name}: {int(np.count_nonzero(np.diff(imu.t_ns) < 0))} samples came late and were sorted")
    return imu.chosen(order)


def without_repeats(imu, notes):
    """After stamps were made regular: a burst of samples may share the stamp of one callback."""
    fresh = np.concatenate(([True], np.diff(imu.t_ns) > 0))
    if not fresh.all():
        notes.append(f"{imu.name}: {int(np.count_nonzero(~fresh))} samples with a stamp that was there already were dropped")
    return imu.chosen(fresh)


def made_regular(imu, mode, notes):
    """Stamps of callbacks to those of a sensor at a steady rate, where `mode` says so."""
    if mode == "recorded" or (mode == "auto" and not stamps.irregular(imu.t_ns)):
        return imu
    if len(imu.t_ns) < 50:
        raise InputError(f"{imu.name}: {len(imu.t_ns)} samples are too few to make stamps regular")
    steady = stamps.regular(imu.t_ns)
    moved = np.abs(steady - imu.t_ns) * 1e-6
    notes.append(f"{imu.name}: stamps scatter like those of callbacks; made regular, moved by {np.median(moved):.2g} ms (median), "
                 f"{np.max(moved):.2g} ms at most; --imu-stamps recorded keeps them")
    imu.t_ns = steady
    return imu


def in_si(imu, options, notes):
    """rad/s and m/s^2. Units are the option's, else the format's, else what gravity says."""
    force_unit = checks.accel_unit(imu.accel)
    unit = options.accel_unit or imu.accel_unit or force_unit
    if unit is None or (not options.accel_unit and force_unit != unit):
        median = float(np.median(np.linalg.norm(imu.accel, axis=1)))
        if median < 3 and unit == "m/s^2":
            raise InputError(f"{imu.name}: median length of the accelerations is {median:.3g}: gravity is not in them, or they are in g "
                             "(--accel-unit g); segcal needs the raw accelerometer, not linear acceleration")
        raise InputError(f"{imu.name}: median length of the accelerations is {median:.3g} where gravity is 9.81 m/s^2; --accel-unit m/s^2|g|mg says what they are")
    if not (options.accel_unit or imu.accel_unit) and unit != "m/s^2":
        notes.append(f"{imu.name}: accelerations taken as {unit}, by the size of gravity")
    if unit != "m/s^2":
        imu.accel = imu.accel * checks.ACCEL_UNITS[unit]
    given = options.gyro_unit or imu.gyro_unit
    if given and given != "rad/s":
        imu.gyro = imu.gyro * checks.GYRO_UNITS[given]
    return given


def in_axes(imu, options):
    for option, name in (("gyro_axes", "gyro"), ("accel_axes", "accel")):
        text = getattr(options, option)
        if not text:
            continue
        try:
            columns, signs = checks.parse_axes(text)
        except ValueError:
            raise InputError(f"--{option.replace('_', '-')} {text}: expected the three axes with signs, such as y,-x,z") from None
        setattr(imu, name, getattr(imu, name)[:, columns] * signs)


def check_against_gravity(imu, declared_unit, notes, warnings):
    unit, axes = checks.gyro_findings(imu.t_ns, imu.gyro, imu.accel)
    fastest = float(np.nanquantile(np.abs(imu.gyro), 0.999))
    if unit is None and fastest > 40:  # 2300 deg/s: above the range of consumer gyroscopes
        unit = "deg/s"
    if unit and declared_unit:
        raise InputError(f"{imu.name}: rates of up to {fastest:.3g} {declared_unit} do not match how gravity turns, {unit} would: --gyro-unit {unit}")
    if unit:
        imu.gyro = imu.gyro * checks.GYRO_UNITS[unit]
        notes.append(f"{imu.name}: rotation rates taken as {unit}, by how gravity turns")
    if axes:
        warnings.append(f"{imu.name}: gyroscope and accelerometer disagree about how gravity turns; they agree with --gyro-axes={axes}")


def prepared(choice, options, notes, warnings):
    """The samples to write, and how many were dropped while merging."""
    whole, gyro, accel = choice.imu(options, notes)
    parts = [whole] if whole else [gyro, accel]
    if any(len(part.t_ns) < 2 for part in parts):
        raise InputError(f"{parts[0].name}: expected IMU samples, found {min(len(p.t_ns) for p in parts)}")
    source = options.stamps or ("sensor" if all(stamps.usable(p.t_ns) for p in parts) else "log")
    if source == "log" and not options.stamps:
        notes.append("the sensors' stamps are missing or run backwards: the time of logging is used for all streams")
    if source == "log" and not all(stamps.usable(p.log_ns) for p in parts):
        raise InputError(f"{parts[0].name}: expected times of logging, found none that grow; " +
                         ("--stamps sensor takes the sensors' stamps" if options.stamps else "the sensors' stamps do not grow either"))
    parts = [without_repeats(made_regular(with_stamps(part, source, notes), options.imu_stamps, notes), notes) for part in parts]
    dropped = 0
    imu = parts[0]
    if len(parts) == 2:
        imu, dropped = merge.merged(*parts)
        if len(imu.t_ns) < 2:
            raise InputError(f"{gyro.name} and {accel.name}: no time that both cover; are their clocks the same?")
        notes.append(f"accelerations of {accel.name} interpolated at the stamps of {gyro.name}; {dropped} samples outside of them dropped")
    declared = in_si(imu, options, notes)
    in_axes(imu, options)
    check_against_gravity(imu, declared, notes, warnings)
    return imu, source, dropped
