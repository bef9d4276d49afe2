// What a wall looks like: photographs hung side by side, with plain patches between them.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "photographs.h"

namespace host::render {

/// A square of `side` px, 8-bit grey: photographs cut, turned and scaled at random (by 1.4 at most), and a third of the
/// patches of low contrast, as walls are.
cv::Mat make_wallpaper(const Photographs& photographs, int side, std::uint64_t seed);

}  // namespace host::render
