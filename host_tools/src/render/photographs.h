// The pictures that simulated rooms are papered with: real photographs, because a tracker lives on what edges, print
// and foliage look like, and noise looks like none of them.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

namespace host::render {

struct Photographs {
  std::vector<cv::Mat> scenes;    ///< 8-bit grey, each at least 300 px wide: objects, faces, a page
  std::vector<cv::Mat> surfaces;  ///< 8-bit grey: brick, gravel, grass
};

/// Where host_tools/setup.sh puts them: scikit-image's example photographs, from its wheel.
std::filesystem::path default_photographs();

/// Reads the folder. Throws InputError where a picture is missing, saying what brings it.
Photographs read_photographs(const std::filesystem::path& folder);

}  // namespace host::render
