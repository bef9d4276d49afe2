#include "diagnose/structure_report.h"

#include <algorithm>

#include "diagnose/held_out_report.h"

namespace host::diagnosis {
namespace {

/// log10 p from which on structure in residuals is reported; all of it.
constexpr double kStructure = -3, kAll = 1e9;

}  // namespace

void report_structure(const std::vector<Recording>& sessions, const ReplayResult& after, Diagnosis* out) {
  std::vector<ImuData> imu;
  imu.reserve(sessions.size());
  for (const Recording& r : sessions) imu.push_back(r.imu);
  const auto lists_of = [&imu](const ReplayResult& fit) {
    return residual_lists(fit.kept, fit.model, fit.calibration, imu);
  };
  out->where = find_structure(lists_of(out->fit_before), kStructure, 2);
  const std::vector<Structure> left = find_structure(lists_of(after), kAll, kCauses);
  refuse_where_structure_is_left(left, out);
  for (const Structure& s : out->where) {
    const auto same = std::find_if(left.begin(), left.end(), [&s](const Structure& a) {
      return a.sensor == s.sensor && a.axis == s.axis && a.against == s.against;
    });
    out->left.push_back(same == left.end() ? Structure{} : *same);
    out->where_after.push_back(out->left.back().correlation);
  }
}

}  // namespace host::diagnosis
