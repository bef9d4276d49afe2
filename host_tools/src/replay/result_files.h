// Writes what a replay found: result.json (format 2, docs/formats.md), calibration.jsonl,
// camchain-imucam.yaml, imu.yaml, trajectory.tum, model.yaml, config.yaml (where it was
// not a device's own), and report_data.json with what the report draws.
#pragma once

#include <nlohmann/json.hpp>

#include "replay/provenance.h"
#include "replay/replay.h"

namespace host {

nlohmann::ordered_json result_json(const ReplayResult& result, const Provenance& provenance = {});
/// One line of JSON for each calibration that ran.
std::string calibration_lines(const ReplayResult& result, const Provenance& provenance);
nlohmann::ordered_json report_data(const ReplayResult& result, const std::vector<TruthPose>& truth);
std::string trajectory_tum(const std::vector<CoreState>& trajectory);
void write_result_files(const std::filesystem::path& dir, const ReplayResult& result, const Provenance& provenance,
                        const std::vector<TruthPose>& truth);

}  // namespace host
