#include "render_images.h"

#include <opencv2/imgcodecs.hpp>

#include "../exposure_file.h"
#include "../file_output.h"
#include "../simulate/exposures.h"
#include "renderer.h"

namespace host::render {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t seed_step_per_camera = 1000003;
constexpr int fast_png = 1;  // zlib's level: noise does not compress, and more effort only costs time

void write_image(const fs::path& file, const cv::Mat& image) {
  if (!cv::imwrite(file.string(), image, {cv::IMWRITE_PNG_COMPRESSION, fast_png}))
    throw InputError(file.string() + ": cannot be written");
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message());
}

}  // namespace

void write_images(const SimulationResult& result, const SimulationOptions& options, const ImageOptions& images,
                  const fs::path& root, const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<double>& times = result.frame_times;
  if (times.empty()) return;
  const Room room =
      make_room(result.trajectory, times.front(), times.back(), read_photographs(images.photographs), options.seed);
  const std::size_t cameras = result.recording.cameras.size();
  for (std::size_t c = 0; c < cameras; ++c) {
    const fs::path folder = root / "mav0" / ("cam" + std::to_string(c));
    make_folder(folder / "data");
    fs::remove(folder / "tracks.csv");  // of an earlier simulation: it would be read instead of the images
    Renderer renderer(room, result.truth.cameras[c], c, result.trajectory, options.effects, result.warm_up);
    Sensor sensor(images.sensor, options.seed + seed_step_per_camera * c);
    std::string list = "#timestamp [ns],filename\n";
    std::vector<Frame> stamped;
    cv::Mat light;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const double exposure_s = sensor.exposure_s();
      renderer.render(times[k] + sim::after_stamp(options.effects, exposure_s), exposure_s, light);
      const std::int64_t t_ns = result.recording.cameras[c].frames[k].t_ns;
      stamped.push_back({t_ns, {}, exposure_s});
      const std::string name = std::to_string(t_ns) + ".png";
      write_image(folder / "data" / name, sensor.image_of(light, k > 0 ? times[k] - times[k - 1] : 0));
      list += std::to_string(t_ns) + "," + name + "\n";
      if (progress) progress(c * times.size() + k + 1, cameras * times.size());
    }
    write_exposures(folder / "exposure.csv", stamped);
    write_file(folder / "data.csv", list);
  }
}

}  // namespace host::render
