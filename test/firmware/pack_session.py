#!/usr/bin/env python3
"""Packs a recording into the fixture that firmware images have compiled in: 16-bit samples and points, like a sensor's.

usage: pack_session.py REC SESSION.bin
Made with: segcal simulate --out rec --scenario rich --seconds 40 --seed 1 --tracks 40; session_120s.bin with --seconds 120
The layout is the one that test/firmware/session.c reads; little endian."""
import csv
import struct
import sys

PIXEL_LSB = 1 / 64  # px; 640 px are 40960 steps


def rows(path):
    with open(path) as file:
        return [line for line in csv.reader(file) if line and not line[0].startswith("#")]


def quantise(values, lsb):
    return [max(-32767, min(32767, round(v / lsb))) for v in values]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    recording, out = sys.argv[1:]
    imu = rows(f"{recording}/mav0/imu0/data.csv")
    tracks = rows(f"{recording}/mav0/cam0/tracks.csv")
    start = int(imu[0][0])
    period = int(imu[1][0]) - start
    if any(int(row[0]) != start + i * period for i, row in enumerate(imu)):
        sys.exit(f"{recording}: IMU samples are not evenly spaced")
    gyro_lsb = 35 / 32768  # rad/s: 2000 deg/s full scale
    accel_lsb = 157 / 32768  # m/s^2: 16 g full scale
    frames = {}
    for stamp, track, u, v in tracks:
        frames.setdefault(int(stamp), []).append((int(track), float(u), float(v)))
    points = sum(len(frame) for frame in frames.values())
    with open(out, "wb") as file:
        file.write(struct.pack("<8sIIII3f4x", b"SEGSESS1", len(imu), len(frames), points, period, gyro_lsb, accel_lsb, PIXEL_LSB))
        for row in imu:
            values = [float(v) for v in row[1:7]]
            file.write(struct.pack("<6h", *quantise(values[:3], gyro_lsb), *quantise(values[3:], accel_lsb)))
        for stamp, frame in sorted(frames.items()):
            file.write(struct.pack("<II", round((stamp - start) / 1000), len(frame)))
            for track, u, v in frame:
                file.write(struct.pack("<3H", track, round(u / PIXEL_LSB), round(v / PIXEL_LSB)))


if __name__ == "__main__":
    main()
