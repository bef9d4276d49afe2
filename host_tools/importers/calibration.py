"""The starting calibration and the IMU's noise of an imported recording."""

import numpy as np

import calibration_folder
from recording import ASSUMED_NOISE, NOISE_NAMES, camchain_text, imu_model_text
from streams import Camera, InputError
from yaml_file import read_yaml

# R_CI by how a camera is mounted: rows are the camera's axes (x right, y down, z forward) in the IMU's.
MOUNTS = {
    # Android's and iOS' sensor axes: x right, y up, z out of the screen; the sensor of the back camera lies across, its x down.
    "phone-back": [[0, -1, 0], [-1, 0, 0], [0, 0, -1]],
    "same-axes": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    # A vehicle's axes: x forward, y left, z up (REP 103).
    "forward": [[0, -1, 0], [0, 0, -1], [1, 0, 0]],
}


def noise_of(options, source):
    """(four figures, where they are from)."""
    if not options.imu_noise:
        if hasattr(source, "noise") and (stated := source.noise()):
            return stated
        return ASSUMED_NOISE, "assumed: a consumer IMU's, several times the data sheet"
    content = read_yaml(options.imu_noise)
    stated = calibration_folder.noise_figures(options.imu_noise, content.get("imu0", content))
    figures = tuple(stated[name] for name in NOISE_NAMES)
    if min(figures) <= 0:
        raise InputError(f"{options.imu_noise}: expected noise figures above 0")
    return figures, f"of {options.imu_noise.name}"


def write(folder, choice, imu, names, accounts, noise, options, notes, warnings):
    """Writes REC/camchain-imucam.yaml, and imu.yaml where the log has that as well; where it is from, or None where there is none. `noise` is the
    IMU's rate in Hz and its four figures."""
    if not names:
        return None
    if options.calib:
        return copied(folder, options.calib, accounts)
    found = [camera_of(choice, imu, name, account, options, notes, warnings) for name, account in zip(names, accounts)]
    if any(camera is None for camera, *_ in found):
        warnings.append("no calibration of the camera in the log: give --calib FILE (Kalibr's camchain-imucam.yaml) to `segcal track` and "
                        "`segcal replay`, or import with --focal PX and --mount NAME for a rough start")
        return None
    if any(T is None for _, T, *_ in found):
        warnings.append("the log does not say how the camera sits on the IMU (/tf_static): import with --mount NAME "
                        f"({', '.join(MOUNTS)}) or --calib FILE")
        return None
    (folder / "camchain-imucam.yaml").write_text(camchain_text(found))
    if options.gyro_axes and not options.mount:
        warnings.append("T_cam_imu is of the gyroscope's axes as recorded, not of --gyro-axes: where those turn a sensor that sits otherwise, --mount NAME or "
                        "--calib FILE states it")
    write_imu_model(folder, choice, imu, noise, options, notes, warnings)
    return "; ".join(dict.fromkeys(origin for *_, origin in found))


def write_imu_model(folder, choice, imu, noise, options, notes, warnings):
    """Not with --mount: T_cam_imu is then of the axes as they are, and the model's frame is turned by a fraction of a degree. Nor where the samples
    are not those that the model is of."""
    first, *rest = imu.name.split(" + ")
    source = choice.owner[first]
    model = source.imu_model(first) if hasattr(source, "imu_model") and not options.mount else None
    if model is None:
        return
    if set(rest) - {first}:
        warnings.append(f"the log's calibration of {first} is not that of the accelerations of {rest[0]}: no imu.yaml, and T_cam_imu is right for {first} "
                        "only; --imu NAME takes both sensors of one IMU")
    elif options.gyro_axes or options.accel_axes:
        warnings.append(f"the log's calibration is of the axes of {first} as recorded, not of --gyro-axes and --accel-axes: no imu.yaml")
    else:
        (folder / "imu.yaml").write_text(imu_model_text(model, *noise))
        notes.append(f"{first}: scales, axes and what turns the accelerometer against the gyroscope as in the log, in imu.yaml")


def copied(folder, file, accounts):
    cameras = calibration_folder.read_chain(file)
    for i, account in enumerate(accounts):
        if i >= len(cameras):
            raise InputError(f"{file}: expected an entry 'cam{i}', one for each of {len(accounts)} cameras")
        if cameras[i].size not in ([0, 0], account["size"]):
            raise InputError(f"{file}: cam{i}: expected resolution {account['size']} as the images of {account['stream']} have, found {cameras[i].size}")
    (folder / "camchain-imucam.yaml").write_text(file.read_text())
    return f"copied from {file.name}"


def camera_of(choice, imu, name, account, options, notes, warnings):
    """(Camera or None, T_CI or None, timeshift in s, origin)."""
    source = choice.owner[name]
    camera = source.calib(name)
    width, height = account["size"]
    origin = "camera as in the log"
    if camera is not None and (camera.width, camera.height) != (width, height):
        warnings.append(f"{name}: calibration for {camera.width} x {camera.height} px, images of {width} x {height}: not used")
        camera = None
    if options.focal > 0:
        camera = Camera(width, height, [options.focal, options.focal, (width - 1) / 2, (height - 1) / 2], "radtan", [0.0] * 4)
        origin = f"camera a pinhole of --focal {options.focal:g} px without distortion"
    if camera is not None:
        notes += [f"{name}: {note}" for note in camera.notes]
    if options.mount:
        T = np.eye(4)
        T[:3, :3] = mount_rotation(options.mount)
        return camera, T, 0.0, f"{origin}, T_cam_imu by --mount {options.mount}"
    first = imu.name.split(" + ")[0]
    if choice.owner.get(first) is not source:
        return camera, None, 0.0, origin
    timeshift_s = source.timeshift(name, first) if hasattr(source, "timeshift") else 0.0
    if options.stamps == "log" and timeshift_s:   # how late a sensor stamps its samples; when they were logged is another matter
        notes.append(f"{name}: the log's {timeshift_s * 1e3:.2f} ms between the clocks of camera and IMU are of the sensors' stamps: not used with --stamps log")
        timeshift_s = 0.0
    return camera, source.extrinsics(name, first), timeshift_s, f"{origin}, T_cam_imu as in the log"


def mount_rotation(name):
    if name not in MOUNTS:
        raise InputError(f"--mount {name}: expected one of {', '.join(MOUNTS)}")
    return np.array(MOUNTS[name], float)
