"""Makes fixtures/import: one small log of each format, half a second of IMU at 100 Hz and three images of 32 x 24, and expected.json with
what `segcal import` must make of each. That is computed here from the arrays that the logs are made of, by docs/formats.md, and never from
the importer's output.   Usage: .venv/bin/python test/importers/make_fixtures.py [FOLDER]

The logs are frozen: test_frozen.py reads them as they are, so that a change in a library that writes and reads alike is seen. Make them
again only for a new format. They are written by rosbags, mcap and pyulog, the video by PyAV (host_tools/importers/requirements-video.txt),
Aria's by vrs_files.py."""

import hashlib
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml
from mcap.reader import make_reader
from mcap.writer import Writer
from PIL import Image
from pyulog import ULog

os.environ.setdefault("SEGCAL_PROGRAM", "none")  # support's; no program is run here
from bags import Bag  # noqa: E402
from support import SOURCE, tumbling  # noqa: E402
from test_formats import ulog  # noqa: E402
from vrs_files import VrsFile, factory  # noqa: E402

WIDTH, HEIGHT = 32, 24
STAMPS, GYRO, ACCEL = tumbling(0.5, 100, seed=19)
IMAGE_STAMPS = STAMPS[[5, 25, 45]]
RNG = np.random.default_rng(19)
# A ramp with some noise: of use to an eye that looks at the file, and compressible.
IMAGES = [(np.add.outer(3 * np.arange(HEIGHT), 4 * np.arange(WIDTH)) + 20 * k + RNG.integers(0, 8, (HEIGHT, WIDTH))).astype(np.uint8) for k in range(3)]
IMU_HEADING = "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],a_y [m s^-2],a_z [m s^-2]\n"


def rows(stamps, *values):
    """CSV with all digits: a number comes back to the same bits."""
    return "".join(f"{t}," + ",".join(map(repr, row)) + "\n" for t, row in zip(stamps.tolist(), np.concatenate(values, axis=1).astype(float).tolist()))


def sha256(data):
    return hashlib.sha256(data).hexdigest()


def outcome(source, stamps=STAMPS, gyro=GYRO, accel=ACCEL, images=IMAGES, needs=None):
    """What comes out of `source`, files of fixtures/import. Pixels are hashed by rows, 16 bits little-endian."""
    entry = {"source": source, "samples": len(stamps), "first_ns": int(stamps[0]), "last_ns": int(stamps[-1]),
             "imu_sha256": sha256((IMU_HEADING + rows(stamps, gyro, accel)).encode()),
             "images": [{"stamp_ns": int(t), "size": [WIDTH, HEIGHT], "bits": 8 * image.itemsize, "sha256": sha256(image.tobytes())}
                        for t, image in zip(IMAGE_STAMPS, images)]}
    return entry | ({"needs": needs} if needs else {})


def write_mcap(source, out):
    """The same messages by MCAP's own library, whose chunks are compressed (zstd)."""
    with source.open("rb") as read, out.open("wb") as write:
        writer, channels = Writer(write), {}
        writer.start(profile="ros2")
        for schema, channel, message in make_reader(read).iter_messages():
            if channel.topic not in channels:
                channels[channel.topic] = writer.register_channel(channel.topic, channel.message_encoding, writer.register_schema(schema.name, schema.encoding, schema.data))
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
        writer.finish()


def put_bags(out):
    with tempfile.TemporaryDirectory() as place:
        for kind, name in (("ros1", "ros1.bag"), ("sqlite3", "ros2_sqlite3"), ("mcap", "ros2_mcap")):
            with Bag(Path(place), kind) as bag:
                for t, w, a in zip(STAMPS.tolist(), GYRO, ACCEL):
                    bag.imu("/imu0", t, w, a)
                    if t in IMAGE_STAMPS:
                        bag.image("/cam0/image_raw", t, IMAGES[IMAGE_STAMPS.tolist().index(t)], "mono8")
            shutil.move(bag.path, out / name)
    write_mcap(next((out / "ros2_mcap").glob("*.mcap")), out / "bare.mcap")
    return {name: outcome([file]) for name, file in
            (("ROS 1 bag", "ros1.bag"), ("ROS 2 bag, SQLite", "ros2_sqlite3"), ("ROS 2 bag, MCAP", "ros2_mcap"), ("MCAP", "bare.mcap"))}


def put_ulog(out):
    """ULog has microseconds and floats, and no images."""
    stamps_us = (STAMPS - STAMPS[0]) // 1000 + 10_000_000
    single = GYRO.astype(np.float32), ACCEL.astype(np.float32)
    with tempfile.NamedTemporaryFile() as first:
        Path(first.name).write_bytes(ulog(stamps_us, *single))
        ULog(first.name).write_ulog(str(out / "px4.ulg"))
    return {"PX4 ULog": outcome(["px4.ulg"], 1000 * stamps_us, *single, images=[])}


def put_image_files(folder, table, images):
    (folder / "data").mkdir(parents=True)
    for t, image in zip(IMAGE_STAMPS, images):
        Image.fromarray(image).save(folder / "data" / f"{t}.png", optimize=True)
    (folder / table).write_text("#timestamp [ns],filename\n" + "".join(f"{t},{t}.png\n" for t in IMAGE_STAMPS))


def put_tables(folder):
    (folder / "gyro.csv").write_text("timestamp [ns],x [rad/s],y [rad/s],z [rad/s]\n" + rows(STAMPS, GYRO))
    (folder / "accel.csv").write_text("timestamp [ns],x [m/s^2],y [m/s^2],z [m/s^2]\n" + rows(STAMPS, ACCEL))


def put_phone(out):
    put_image_files(out / "phone_csv/camera", "frames.csv", IMAGES)
    put_tables(out / "phone_csv")
    lines = [{"sensor": sensor, "timestamp": t, **dict(zip("xyz", value))} for t, w, a in zip(STAMPS.tolist(), GYRO.tolist(), ACCEL.tolist())
             for sensor, value in (("gyroscope", w), ("accelerometer", a))]
    (out / "phone.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    return {"phone, CSV": outcome(["phone_csv"]), "phone, JSON lines": outcome(["phone.jsonl"], images=[])}


def put_folders(out):
    """EuRoC's with 8-bit images, TUM-VI's with 16-bit images and dso/camchain.yaml."""
    wide = [image.astype(np.uint16) * 257 for image in IMAGES]
    for name, images in (("euroc", IMAGES), ("tum_vi", wide)):
        (out / name / "mav0/imu0").mkdir(parents=True)
        (out / name / "mav0/imu0/data.csv").write_text("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y,w_RS_S_z,a_RS_S_x [m s^-2],a_RS_S_y,a_RS_S_z\n"
                                                       + rows(STAMPS, GYRO, ACCEL))
        put_image_files(out / name / "mav0/cam0", "data.csv", images)
    (out / "tum_vi/dso").mkdir()
    camera = {"T_cam_imu": np.eye(4).tolist(), "camera_model": "pinhole", "distortion_model": "equidistant",
              "distortion_coeffs": [0.01, 0.02, -0.01, 0.002], "intrinsics": [20.0, 20.0, 16.0, 12.0], "resolution": [WIDTH, HEIGHT]}
    (out / "tum_vi/dso/camchain.yaml").write_text(yaml.safe_dump({"cam0": camera}))
    return {"EuRoC folder": outcome(["euroc"]), "TUM-VI folder": outcome(["tum_vi"], images=wide)}


def put_video(out):
    """FFV1 is lossless."""
    import av

    (out / "video").mkdir()
    put_tables(out / "video")
    with av.open(str(out / "video/clip.mkv"), "w", options={"fflags": "bitexact"}) as container:
        stream = container.add_stream("ffv1", rate=5)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "gray"
        for image in IMAGES:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
        container.mux(stream.encode())
    (out / "video/clip.csv").write_text("timestamp [ns],frame\n" + "".join(f"{t},{k}\n" for k, t in enumerate(IMAGE_STAMPS)))
    return {"video and tables": outcome(["video/clip.mkv", "video/gyro.csv", "video/accel.csv"], needs="av")}


def put_vrs(out):
    """Gen 1's streams; single precision, and stamps since the device was switched on."""
    since_boot_ns = int(STAMPS[0]) - 280_566_996_375
    single = GYRO.astype(np.float32), ACCEL.astype(np.float32)
    lens, turned = [20.0, 16.0, 12.0, -0.03, 0.1, -0.07, 0.01, 0.0, 0.0, 0.002, -0.001, 0.003, 0.0, -0.002, 0.0], (0.6, 0.48, -0.64, 0.0)
    M = [[1.004, -0.002, 0.003], [0.011, 0.995, -0.004], [-0.006, 0.009, 1.002]]
    vrs = VrsFile(factory((WIDTH, HEIGHT), {"camera-slam-left": (lens, (turned, (0.01, -0.02, 0.005)))},
                          {"imu-right": (M, np.triu(M), ((0.5, -0.5, 0.5, 0.5), (0.0046, -0.102, -0.086)), 0.0041, 0.0028)}))
    vrs.imu("1202-1", STAMPS - since_boot_ns, *single)
    vrs.camera("1201-1", IMAGE_STAMPS - since_boot_ns, IMAGES, (WIDTH, HEIGHT))
    vrs.write(out / "aria.vrs")
    expected = outcome(["aria.vrs"], STAMPS - since_boot_ns, *single, needs="pyvrs")
    for image, t in zip(expected["images"], IMAGE_STAMPS - since_boot_ns):
        image["stamp_ns"] = int(t)
    return {"Aria, VRS": expected}


def main():
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else SOURCE / "fixtures/import"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    expected = put_bags(out) | put_ulog(out) | put_phone(out) | put_folders(out) | put_video(out) | put_vrs(out)
    (out / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")


if __name__ == "__main__":
    main()
