#!/bin/bash
# Usage: same_table.sh FEED FIRMWARE_LOOP IMU.csv TRACKS.csv
# Both programs calibrate the same device; what they print must be the same. Prints the difference if it is not.
set -euo pipefail
table=$("$1" "$3" "$4")
[ -n "$table" ]
diff <(echo "$table") <("$2" "$3" "$4")
