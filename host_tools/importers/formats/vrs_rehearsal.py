"""Reads the first records of each stream of a VRS file: vrs_rehearsal.py FILE. On names that are damaged the library ends by a signal, which
here hurts nobody; what it raises is told by the importer when it comes to it."""

import contextlib
import sys

from pyvrs import SyncVRSReader


def main(file):
    reader = SyncVRSReader(file)
    for stream in reader.stream_ids:
        for kind in ("configuration", "data"):
            records = reader.filtered_by_fields(stream_ids={stream}, record_types={kind})
            with contextlib.suppress(RuntimeError, ValueError, IndexError):
                dict(records[0].metadata_blocks[0])


if __name__ == "__main__":
    main(sys.argv[1])
