"""The chain of records of a VRS file: which streams it holds, and whether it is whole.

The library `vrs` reads a file that was cut as far as it goes and does not say so; the chain does. Little-endian: a file header of 80 bytes
(magic, sizes of file and record headers, places of index, description and first record), then records, each with its own size and that of
the one before. There are no checksums: damage inside of a record shows only where its content is compressed, or an image."""

import mmap
import struct
from collections import Counter

from streams import InputError

MAGIC = b"VisionRe"
FILE_HEADER = struct.Struct("<8sQIIqqqQQQ4s4s")
RECORD_HEADER = struct.Struct("<IIiIdHBBI")  # size, size before, stream's type, format, time, stream's instance, kind, compression, unpacked size
SIZE = struct.Struct("<I")
KINDS = {1: "state", 2: "configuration", 3: "data", 4: "tags"}
OF_THE_FILE = {1, 2}  # types of streams that hold VRS's own index and description
COMPRESSIONS = 4  # none, LZ4, Zstandard, and a value that marks the end of the list


def begins_like_vrs(path):
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def data_records(path):
    """Number of data records by stream, "1202-1" and the like. Raises InputError where the chain is broken."""
    size = path.stat().st_size
    if path.with_name(path.name + "_1").exists():
        raise InputError(f"{path}: a VRS file in several pieces ({path.name}_1, ...): expected one file, as Aria's are")
    if size < FILE_HEADER.size:
        raise InputError(f"{path}: damaged VRS file: {size} bytes, fewer than its header")
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        header = FILE_HEADER.unpack_from(data)
        header_size, record_header, description, first = header[2], header[3], header[5], header[6]
        if header_size < FILE_HEADER.size or record_header < RECORD_HEADER.size or not 0 <= description <= size - SIZE.size or not 0 <= first <= size:
            raise InputError(f"{path}: damaged VRS file: byte 16: expected sizes and places inside of its {size} bytes")
        end = description + SIZE.unpack_from(data, description)[0]
        at = first or end
        if at > size or end > size:
            raise InputError(f"{path}: damaged VRS file: expected its first record at byte {max(at, end)}, found the end of the file after {size}")
        return walked(path, data, at, record_header)


def walked(path, data, at, record_header):
    counts, before = Counter(), None
    while at < len(data):
        if at + record_header > len(data):
            raise InputError(f"{path}: damaged VRS file: byte {at}: expected a record, found the end of the file")
        size, size_before, stream, _, _, instance, kind, compression, _ = RECORD_HEADER.unpack_from(data, at)
        if size < record_header or kind not in KINDS or compression >= COMPRESSIONS or size_before != (size_before if before is None else before):
            raise InputError(f"{path}: damaged VRS file: byte {at}: expected a record")
        if at + size > len(data):
            raise InputError(f"{path}: damaged VRS file: byte {at}: expected a record of {size} bytes, found the end of the file after {len(data) - at}")
        if KINDS[kind] == "data" and stream not in OF_THE_FILE:
            counts[f"{stream}-{instance}"] += 1
        at, before = at + size, size
    return counts
