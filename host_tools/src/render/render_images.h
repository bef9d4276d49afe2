// A simulated session as images: `segcal simulate --images`.
#pragma once

#include <filesystem>
#include <functional>

#include "../simulate/simulate.h"
#include "photographs.h"
#include "sensor.h"

namespace host::render {

struct ImageOptions {
  SensorOptions sensor;
  std::filesystem::path photographs = default_photographs();
};

/// Renders the frames of a session that was simulated with `options` (SimulationOptions::images) and writes
/// mav0/camN/data/STAMP.png and, when all are there, mav0/camN/data.csv and exposure.csv under `root`. A stamp is the
/// middle of the exposure, with a rolling shutter that of the middle row. `progress(done, all)` is called after each
/// image. Throws InputError where a photograph is missing or the disk refuses.
void write_images(const SimulationResult& result, const SimulationOptions& options, const ImageOptions& images,
                  const std::filesystem::path& root,
                  const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace host::render
