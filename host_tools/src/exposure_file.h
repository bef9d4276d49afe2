// camN/exposure.csv: for how long each image was exposed (docs/formats.md, "A recording").
#pragma once

#include <filesystem>

#include "recording.h"

namespace host {

/// Gives each frame of the rig the exposure that the file says of its stamp; nothing where there is no file. To be
/// called while stamps are as they are in the files. Throws InputError for a bad line.
void read_exposures(const std::filesystem::path& file, Recording* recording);

/// Of the frames that have one; no file where none has.
void write_exposures(const std::filesystem::path& file, const std::vector<Frame>& frames);

}  // namespace host
