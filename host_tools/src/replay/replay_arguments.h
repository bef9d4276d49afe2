// What `segcal replay` is told on its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "replay/replay.h"

namespace host {

struct ReplayArguments {
  std::vector<std::string> recordings;
  std::string calibration, out, model, config, strategy, verify_hash, device_id, state;
  std::vector<std::string> effects;
  int cameras = 1;
  bool json = false, no_calibration = false, keep_outdated = false, hash = false, smooth_stamps = false,
       keep_clock = false, estimate_track_noise = false, without_state = false;
  std::optional<double> stamp_exposure;  ///< times the exposure, added to the stamps of images
  bool states_corner_noise = false;      ///< in --config
  ReplayOptions replay;
  std::vector<CLI::Option*> of_device;  ///< what a device log says itself
  CLI::Option *profile = nullptr, *pixel_sigma = nullptr, *track_walk = nullptr;
};

/// `a` must live as long as `sub` is parsed.
void add_replay_options(CLI::App* sub, ReplayArguments* a);

}  // namespace host
