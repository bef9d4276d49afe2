#include "experiments/methods.h"

#include <algorithm>

#include "reference/reference.h"
#include "simulate/device.h"

namespace host::experiments {
namespace {

constexpr int all_segments = 64;  // what the largest profile holds

std::vector<SessionCalibration> from_database(const std::vector<Recording>& sessions, const Calibration& start,
                                              const std::string& profile, const std::string& metric,
                                              const MethodOptions& options) {
  std::vector<SessionCalibration> out;
  ReplayOptions r;
  r.core.calibration = start;
  r.core.noise = sessions.front().imu.noise;
  r.core.metric = metric;
  r.core.condense = options.condense;
  r.core.multi_session = options.multi_session;
  r.core.segments = options.segments;
  r.core.seed = options.seed;
  r.profile = profile;
  r.after_session = [&out](std::size_t, const CoreResult& result, const Calibration& calibration) {
    out.push_back({calibration, result});
  };
  replay(sessions, r);
  return out;
}

std::vector<SessionCalibration> initial(const std::vector<Recording>& sessions, const Calibration& start, const Method&,
                                        const MethodOptions&) {
  return std::vector<SessionCalibration>(sessions.size(), {start, {}});
}

/// Full batch by the independent solver: all keyframes and landmarks of all sessions so far, or of each alone.
std::vector<SessionCalibration> batch(const std::vector<Recording>& sessions, const Calibration& start, const Method&,
                                      const MethodOptions& options) {
  std::vector<SessionCalibration> out;
  ReferenceOptions r;
  r.calibration = start;
  r.noise = sessions.front().imu.noise;
  for (auto end = sessions.begin() + 1; end <= sessions.end(); ++end) {
    const ReferenceResult solved = reference_batch({options.multi_session ? sessions.begin() : end - 1, end}, r);
    out.push_back({solved.calibration, solved.result});
  }
  return out;
}

/// The filter with all of theta in its state, without segments; it goes on from session to session.
std::vector<SessionCalibration> joint_filter(const std::vector<Recording>& sessions, const Calibration& start,
                                             const Method&, const MethodOptions&) {
  std::vector<SessionCalibration> out;
  ReplayOptions r;
  r.core.calibration = start;
  r.core.noise = sessions.front().imu.noise;
  r.joint_ekf = true;
  r.after_session = [&out](std::size_t, const CoreResult& result, const Calibration& calibration) {
    out.push_back({calibration, result});
  };
  replay(sessions, r);
  return out;
}

/// Every segment, up to what profile host holds.
std::vector<SessionCalibration> no_sparsification(const std::vector<Recording>& sessions, const Calibration& start,
                                                  const Method&, const MethodOptions& options) {
  MethodOptions o = options;
  o.segments = all_segments;
  return from_database(sessions, start, "host", "A", o);
}

std::vector<SessionCalibration> selected(const std::vector<Recording>& sessions, const Calibration& start,
                                         const Method& method, const MethodOptions& options) {
  return from_database(sessions, start, "mobile", method.metric, options);
}

/// Eight kept segments, the first that told enough, and all that came after them in epochs.
std::vector<SessionCalibration> condensed(const std::vector<Recording>& sessions, const Calibration& start,
                                          const Method& method, const MethodOptions& options) {
  MethodOptions o = options;
  o.condense = true;
  return from_database(sessions, start, "mobile", method.metric, o);
}

bool always() { return true; }

bool metric_offered(const char* metric) {
  CoreOptions options;
  options.calibration = sim::nominal_device(DistortionModel::fov, 1);
  options.metric = metric;
  try {
    return make_core("mobile", options) != nullptr;
  } catch (const InputError&) {
    return false;
  }
}

bool set_d_offered() { return metric_offered("set_d"); }

}  // namespace

const std::vector<Method>& methods() {
  static const std::vector<Method> offered = [] {
    const std::vector<Method> known = {
        {"initial", "the data sheet's calibration", always, initial, ""},
        {"batch", "all keyframes and landmarks, solved by Ceres (segcal reference)", always, batch, ""},
        {"all", "no sparsification: all segments, up to 64", always, no_sparsification, ""},
        {"A", "8 segments of 4 s by A (trace)", always, selected, "A"},
        {"D", "8 segments of 4 s by D (determinant)", always, selected, "D"},
        {"E", "8 segments of 4 s by E (largest eigenvalue)", always, selected, "E"},
        {"set_d", "8 segments of 4 s by the joint determinant", set_d_offered, selected, "set_d"},
        {"random", "8 segments of 4 s at random", always, selected, "random"},
        {"condensed", "8 segments of 4 s by A, all later ones in epochs", always, condensed, "A"},
        {"joint_ekf", "the filter with all of theta in its state", always, joint_filter, ""},
        {"filter", "the data sheet's, and the filter's own estimates on the way", always, initial, "",
         Odometry::estimating},
        {"filter_A", "as A, and the filter's own estimates on the way", always, selected, "A", Odometry::estimating},
    };
    std::vector<Method> out;
    std::copy_if(known.begin(), known.end(), std::back_inserter(out), [](const Method& m) { return m.offered(); });
    return out;
  }();
  return offered;
}

const Method& method_named(const std::string& name) {
  for (const Method& m : methods()) {
    if (name == m.name) return m;
  }
  throw InputError("method '" + name + "' is not offered");
}

std::vector<SessionCalibration> calibrate(const std::string& method, const std::vector<SimulationResult>& sessions,
                                          const MethodOptions& options) {
  std::vector<Recording> recordings;
  for (const SimulationResult& s : sessions) recordings.push_back(s.recording);
  const Method& m = method_named(method);
  return m.run(recordings, sessions.front().nominal, m, options);
}

}  // namespace host::experiments
