// From recordings to rows: replays with chosen effects estimated, and linearises at that fit.
#pragma once

#include <deque>
#include <functional>

#include "diagnose/budget.h"
#include "diagnose/exposure_offset.h"
#include "diagnose/sensor_gap.h"
#include "replay/core_side.h"
#include "replay/replay.h"

namespace host::diagnosis {

/// What is before a step of the calibration or after it, fitted by itself. A segment that the step falls into has none.
struct FitSide {
  std::vector<std::uint32_t> serials;
  std::unique_ptr<CoreSide> core;
};

/// One fit, with everything that was linearised at it.
struct MadeFit {
  std::vector<double> asked;   ///< what it depends on (Evidence::question)
  std::vector<double> beside;  ///< the terms, in the caller's order, that its rows have columns for
  std::unique_ptr<Core> core;
  std::vector<FitSide> sides;  ///< where rows are linearised at each side's own theta; else at the fit's
  ReplayResult result;
  std::vector<TermInfo> taken, candidates;
  std::vector<int> place;  ///< of each of the caller's terms that the core has among [taken | candidates]
  ExposureColumn exposure;
  Eigen::VectorXd taken_values;
  int n_theta = 0;
  int inflations = 0;  ///< of the noise, that it needed
  Problem problem;
};

/// The last fit, and a few before it, which are not made again.
class Evidence {
 public:
  Evidence(const std::vector<Recording>& sessions, const CoreOptions& options, const std::string& profile,
           Budget* budget, std::function<void(double)> progress);

  /// Replays with these terms estimated, from these values on, and linearises with the others as candidates. Columns
  /// are theta, then `terms` in their order.
  Problem fit(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated, const std::vector<double>& start);
  /// The same, both sides of the step linearised at their own theta, which is counted from the fit's. `before`,
  /// `after`: where it is expected, per entry of theta without terms. Until the next fit(), all rows are those; where a
  /// side's fit is lost they stay as they were.
  Problem at_step(const Shift& step, const Eigen::VectorXd& before, const Eigen::VectorXd& after);
  const ReplayResult& result() const { return made_.front()->result; }
  /// The same fit's rows with other candidates; columns are theta, the terms that were estimated, `candidates`. Halves
  /// and pieces only `in_parts`: many candidates are asked about without.
  Problem at_last_fit(const std::vector<TermInfo>& candidates, bool in_parts);
  const std::vector<TermInfo>& taken() const { return made_.front()->taken; }
  /// Rows of the last fit for segments at these places in the order of time, over the same columns, joined where one
  /// follows the other.
  Rows joined(const std::vector<std::size_t>& places);
  /// The pieces of the last fit, sensor by sensor, over the same columns.
  SensorPieces sensors();
  /// Kept segments in the order of time.
  std::vector<CoreKept> segments() const;
  CoreOptions& options() { return options_; }

 private:
  MadeFit& now() { return *made_.front(); }
  const MadeFit& now() const { return *made_.front(); }
  std::vector<double> question(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                               const std::vector<double>& start) const;
  bool remembers(const std::vector<double>& asked);
  void make(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated, const std::vector<double>& start);
  void linearise(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                 const std::vector<double>& start);
  void gather_columns();
  void inflate_until_taken(ReplayOptions options, int enough);
  bool try_fit(const ReplayOptions& options);
  const std::vector<Recording>& stamped(double kappa);
  Problem gather(const std::vector<TermInfo>& candidates, bool in_parts);
  Rows rows_of(const std::vector<std::uint32_t>& serials, const std::vector<TermInfo>& candidates);
  const FitSide* side_with(std::uint32_t serial) const;
  Rows counted(const CoreRows& core, const std::vector<double>& moved) const;
  void count_from_zero(const std::vector<double>& moved, Rows* rows) const;
  double seconds_after_start(std::int64_t t_ns) const;

  const std::vector<Recording>& sessions_;
  std::vector<Recording> moved_;  ///< with kappa_ times the exposure added to the stamps
  double kappa_ = 0;
  CoreOptions options_;
  std::string profile_;
  Budget* budget_;
  std::function<void(double)> progress_;
  std::deque<std::unique_ptr<MadeFit>> made_;  ///< the last one first
};

}  // namespace host::diagnosis
