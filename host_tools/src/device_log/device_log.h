// A device's log (docs/formats.md, lib/include/segcal/log.h) as recordings.
#pragma once

#include "calibration_file.h"
#include "device_log/log_blocks.h"

namespace host {

struct DeviceLog {
  std::vector<Recording> sessions;  ///< each with its calls in Recording::device
  Calibration calibration;          ///< where the device started from
  ImuNoise noise;
  double pixel_sigma = 0.5;        ///< px
  bool left_state_out = false;     ///< it begins with the device's state, of which blocks may be missing
  std::vector<std::string> notes;  ///< what a user should know: a torn end, a log that was not closed, damage left out
};

/// By its first bytes; false for folders and for files that cannot be read.
bool is_device_log(const std::filesystem::path& file);

enum class Damaged {
  refuse,    ///< a hole in the data gives another result than the device's, and nobody would see it
  leave_out  ///< what can be saved, with a note for each hole
};

/// Throws InputError with file, byte and what was expected. A torn end is survived: power goes when it goes.
DeviceLog read_device_log(const std::filesystem::path& file, Damaged damaged = Damaged::refuse);
DeviceLog parse_device_log(const std::filesystem::path& name, const std::vector<std::uint8_t>& bytes, Damaged damaged);

/// Result hashes in a file: of a device log its marks in order; else the number after the word result_hash in a text,
/// as `segcal replay --hash` prints it. Throws InputError if there is none.
std::vector<std::uint64_t> read_hashes(const std::filesystem::path& file);

/// Sixteen hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace host
