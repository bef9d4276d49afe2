// From recordings to rows: replays with chosen effects estimated, and linearises at that fit.
#pragma once

#include <functional>

#include "diagnose/model_terms.h"
#include "diagnose/sensor_gap.h"
#include "replay/replay.h"

namespace host::diagnosis {

/// One fit, with everything that was linearised at it.
class Evidence {
 public:
  Evidence(const std::vector<Recording>& sessions, const CoreOptions& options, const std::string& profile,
           std::function<void(double)> progress);

  /// Replays with these terms estimated, from these values on, and linearises with the others as candidates. Columns
  /// are theta, then `terms` in their order.
  Problem fit(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated, const std::vector<double>& start);
  const ReplayResult& result() const { return result_; }
  /// The same fit's rows with other candidates; columns are theta, the terms that were estimated, `candidates`. Halves
  /// and pieces only `in_parts`: many candidates are asked about without.
  Problem at_last_fit(const std::vector<TermInfo>& candidates, bool in_parts);
  const std::vector<TermInfo>& taken() const { return taken_; }
  /// Rows of the last fit for segments at these places in the order of time, over the same columns, joined where one
  /// follows the other.
  Rows joined(const std::vector<std::size_t>& places);
  /// The pieces of the last fit, sensor by sensor, over the same columns.
  SensorPieces sensors();
  /// Kept segments in the order of time.
  std::vector<CoreKept> segments() const;
  CoreOptions& options() { return options_; }

 private:
  bool try_fit(const ReplayOptions& options);
  Problem gather(const std::vector<TermInfo>& candidates, bool in_parts);
  Rows rows_of(const std::vector<std::uint32_t>& serials, const std::vector<TermInfo>& candidates);
  void count_from_zero(Rows* rows) const;
  double seconds_after_start(std::int64_t t_ns) const;

  const std::vector<Recording>& sessions_;
  CoreOptions options_;
  std::string profile_;
  std::function<void(double)> progress_;
  std::unique_ptr<Core> core_;
  ReplayResult result_;
  std::vector<TermInfo> taken_, asked_;
  std::vector<int> place_;  ///< of each of the caller's terms among [taken | asked]
  Eigen::VectorXd taken_values_;
  int n_theta_ = 0;
  int inflations_ = 0;  ///< that the last fit needed
};

}  // namespace host::diagnosis
