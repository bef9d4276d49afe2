#include "exposure_file.h"

#include <cmath>
#include <unordered_map>

#include "csv.h"
#include "file_output.h"

namespace host {
namespace {

constexpr double longest_exposure_ns = 1e9;  // of a camera that moves: more is another unit, or another column

}  // namespace

void read_exposures(const std::filesystem::path& file, Recording* recording) {
  if (!std::filesystem::exists(file)) return;
  std::unordered_map<std::int64_t, double> exposure_s;
  CsvReader csv(file, "timestamp [ns], exposure [ns]", 2, 2);
  while (csv.next_row()) {
    const double ns = csv.number(1);
    if (!(ns >= 0 && ns <= longest_exposure_ns))
      csv.fail("an exposure of 0 (not known) to 1e9 ns, found " + std::string(csv.text(1)));
    exposure_s[csv.stamp(0)] = 1e-9 * ns;
  }
  for (CameraData& camera : recording->cameras) {
    for (Frame& frame : camera.frames) {
      const auto found = exposure_s.find(frame.t_ns);
      if (found != exposure_s.end()) frame.exposure_s = found->second;
    }
  }
}

void write_exposures(const std::filesystem::path& file, const std::vector<Frame>& frames) {
  std::string text;
  for (const Frame& frame : frames) {
    if (!(frame.exposure_s > 0)) continue;
    append_number(text, frame.t_ns);
    text += ',';
    append_number(text, static_cast<std::int64_t>(std::llround(1e9 * frame.exposure_s)));
    text += '\n';
  }
  if (!text.empty()) write_file(file, "#timestamp [ns],exposure [ns]\n" + text);
}

}  // namespace host
