#include "photographs.h"

#include <opencv2/imgcodecs.hpp>

#include "../recording.h"

namespace host::render {
namespace {

constexpr const char* scene_names[] = {"astronaut.png", "camera.png",          "chelsea.png", "coffee.png",
                                       "coins.png",     "motorcycle_left.png", "page.png",    "rocket.jpg"};
constexpr const char* surface_names[] = {"brick.png", "gravel.png", "grass.png"};

cv::Mat read(const std::filesystem::path& file) {
  const cv::Mat picture = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (picture.empty())
    throw InputError(
        file.string() +
        ": expected a photograph for the rendered room; host_tools/setup.sh brings it (or --photographs FOLDER)");
  return picture;
}

}  // namespace

std::filesystem::path default_photographs() {
  return std::filesystem::path(SEGCAL_SOURCE_DIR) / "third_party" / "photographs";
}

Photographs read_photographs(const std::filesystem::path& folder) {
  Photographs out;
  for (const char* name : scene_names) out.scenes.push_back(read(folder / name));
  for (const char* name : surface_names) out.surfaces.push_back(read(folder / name));
  return out;
}

}  // namespace host::render
