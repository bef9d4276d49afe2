#include "replay/result_files.h"

#include <cstdio>

#include "files/output_run.h"
#include "replay/kept_segments.h"
#include "replay/model_file.h"

namespace host {

std::string trajectory_tum(const std::vector<CoreState>& trajectory) {
  std::string text = "# timestamp [s] p_GI x y z [m] q_GI x y z w\n";
  char line[256];
  for (const CoreState& s : trajectory) {
    // Seconds and nanoseconds apart: a double of seconds since 1970 holds no nanoseconds.
    std::snprintf(line, sizeof line, "%lld.%09lld %.7f %.7f %.7f %.8f %.8f %.8f %.8f\n",
                  static_cast<long long>(s.t_ns / 1000000000), static_cast<long long>(s.t_ns % 1000000000), s.p_GI.x(),
                  s.p_GI.y(), s.p_GI.z(), s.q_GI_wxyz(1), s.q_GI_wxyz(2), s.q_GI_wxyz(3), s.q_GI_wxyz(0));
    text += line;
  }
  return text;
}

void write_result_files(const std::filesystem::path& dir, const ReplayResult& result, const Provenance& provenance,
                        const std::vector<TruthPose>& truth) {
  OutputRun run(dir, "replay");
  write_camchain(dir / "camchain-imucam.yaml", result.calibration);
  write_imu_yaml(dir / "imu.yaml", result.calibration, result.noise);
  write_file(dir / "trajectory.tum", trajectory_tum(result.trajectory));
  write_file(dir / "model.yaml", model_yaml(result));
  if (!result.config.empty()) write_file(dir / "config.yaml", result.config);
  write_file(dir / "report_data.json", report_data(result, truth).dump());
  write_file(dir / "kept_segments.json", kept_segments_json(kept_segments(result)));
  write_file(dir / "calibration.jsonl", calibration_lines(result, provenance));
  write_file(dir / "result.json", result_json(result, provenance).dump(1) + "\n");
  run.finish();
}

}  // namespace host
