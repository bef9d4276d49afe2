#include "diagnose/residuals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diagnose/raw_motion.h"
#include "replay/track_residuals.h"

namespace host::diagnosis {
namespace {

using Eigen::Vector2d;

constexpr struct {
  const char *words, *unit;
} kCauseWords[kCauses] = {{"time", "s"},
                          {"temperature", "degC"},
                          {"rate x", "rad/s"},
                          {"rate y", "rad/s"},
                          {"rate z", "rad/s"},
                          {"change of rate x", "rad/s^2"},
                          {"change of rate y", "rad/s^2"},
                          {"change of rate z", "rad/s^2"},
                          {"force x", "m/s^2"},
                          {"force y", "m/s^2"},
                          {"force z", "m/s^2"},
                          {"speed", "m/s"},
                          {"image x", "px"},
                          {"image y", "px"},
                          {"distance from the image's middle", "px"},
                          {"image motion x", "px/s"},
                          {"image motion y", "px/s"},
                          {"image line times rate", "px rad/s"}};

struct Entry {
  double value = 0;
  int series = 0;
  double cause[kCauses] = {};
};

void set_motion(const RawMotion::Means& m, Entry* e) {
  e->cause[static_cast<int>(Cause::temperature)] = m.temperature;
  for (int i = 0; i < 3; ++i) {
    e->cause[static_cast<int>(Cause::rate_x) + i] = m.rate(i);
    e->cause[static_cast<int>(Cause::rate_change_x) + i] = m.rate_change(i);
    e->cause[static_cast<int>(Cause::force_x) + i] = m.force(i);
  }
}

bool applies(Cause cause, bool camera, bool has_temperature) {
  if (cause == Cause::temperature) return has_temperature;
  return camera || cause < Cause::image_x;
}

void append(const Entry& e, bool camera, bool has_temperature, ResidualList* list) {
  list->value.push_back(e.value);
  list->series.push_back(e.series);
  for (int c = 0; c < kCauses; ++c) {
    if (applies(static_cast<Cause>(c), camera, has_temperature)) list->cause[c].push_back(e.cause[c]);
  }
}

Vector2d middle_of(const std::vector<CoreKept>& kept) {
  Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const CoreKept& k : kept) {
    for (const CorePoint& p : k.measured) {
      low = low.cwiseMin(Vector2d(p.u, p.v));
      high = high.cwiseMax(Vector2d(p.u, p.v));
    }
  }
  return 0.5 * (low + high);
}

/// Where the fit sees each point, px. Measured points hold the very noise that is in their residuals, with the other
/// sign: a cause made of them is followed by white noise, the more the slower the image moves. What least squares
/// predict is not correlated with what they leave: for white noise of covariance s^2 I and the projector H on the
/// columns of the fit cov((I - H) n, H n) = s^2 (I - H) H = 0. The same holds for noise that is whitened along the
/// tracks, in its whitened coordinates.
std::vector<Vector2d> predicted_points(const CoreKept& kept, const std::vector<SeenPoint>& seen,
                                       const CoreModel& model) {
  const std::vector<Vector2d> r_px = residuals_px(kept, model);
  std::vector<Vector2d> out;
  out.reserve(seen.size());
  for (const SeenPoint& s : seen)
    out.push_back(Vector2d(s.point->u, s.point->v) + r_px[static_cast<std::size_t>(s.residual - kept.points.data())]);
  return out;
}

/// Of the same landmark from the keyframe before to the one after,
/// px/s; at the ends of a track from or to the point itself.
Vector2d image_motion(const std::vector<SeenPoint>& seen, const std::vector<Vector2d>& predicted, std::size_t i,
                      const CoreKept& kept) {
  const auto same_track = [&seen, i](std::size_t j) {
    return j < seen.size() && seen[j].point->landmark == seen[i].point->landmark &&
           seen[j].point->camera == seen[i].point->camera;
  };
  const std::size_t from = i > 0 && same_track(i - 1) ? i - 1 : i, to = same_track(i + 1) ? i + 1 : i;
  const double dt = 1e-9 * static_cast<double>(kept.keyframes[seen[to].point->keyframe].t_ns -
                                               kept.keyframes[seen[from].point->keyframe].t_ns);
  if (dt == 0) return {0, 0};
  return (predicted[to] - predicted[from]) / dt;
}

void add_camera(const CoreKept& kept, const CoreModel& model, const Calibration& calibration, const RawMotion& motion,
                const Vector2d& middle, std::int64_t zero_ns, int* series, ResidualList* u, ResidualList* v,
                ResidualList* radial) {
  std::vector<RawMotion::Means> at;
  for (const CoreState& x : kept.keyframes) at.push_back(motion.over(x.t_ns - 25000000, x.t_ns + 25000000));
  const std::vector<SeenPoint> seen = seen_points(kept);
  const std::vector<Vector2d> predicted = predicted_points(kept, seen, model);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const CorePoint& p = *seen[i].point;
    if (i == 0 || seen[i - 1].point->landmark != p.landmark) ++*series;
    const Vector2d place = predicted[i] - middle, flow = image_motion(seen, predicted, i, kept);
    Entry e;
    e.series = *series;
    set_motion(at[p.keyframe], &e);
    e.cause[static_cast<int>(Cause::time)] = 1e-9 * static_cast<double>(kept.keyframes[p.keyframe].t_ns - zero_ns);
    e.cause[static_cast<int>(Cause::speed)] = kept.keyframes[p.keyframe].v_GI.norm();
    e.cause[static_cast<int>(Cause::image_x)] = place.x();
    e.cause[static_cast<int>(Cause::image_y)] = place.y();
    e.cause[static_cast<int>(Cause::radius)] = place.norm();
    e.cause[static_cast<int>(Cause::image_motion_x)] = flow.x();
    e.cause[static_cast<int>(Cause::image_motion_y)] = flow.y();
    // Lines are read one after another: the error follows the line and how fast the image moves there.
    const double line = calibration.cameras[static_cast<std::size_t>(p.camera)].line_of(place);
    e.cause[static_cast<int>(Cause::row_times_rate)] = line * flow.x();
    e.value = seen[i].residual->u_sigma;
    append(e, true, motion.has_temperature(), u);
    e.cause[static_cast<int>(Cause::row_times_rate)] = line * flow.y();
    e.value = seen[i].residual->v_sigma;
    append(e, true, motion.has_temperature(), v);
    if (place.norm() < 1) continue;
    e.value = Vector2d(seen[i].residual->u_sigma, seen[i].residual->v_sigma).dot(place.normalized());
    append(e, true, motion.has_temperature(), radial);
  }
}

void add_imu(const CoreKept& kept, const RawMotion& motion, std::int64_t zero_ns, int series, ResidualList* gyro,
             ResidualList* accel) {
  for (std::size_t k = 0; k < kept.imu.size(); ++k) {
    const CoreImuResidual& r = kept.imu[k];
    const auto at = std::find_if(kept.keyframes.begin(), kept.keyframes.end(),
                                 [&r](const CoreState& x) { return x.t_ns == r.t_ns; });
    if (at == kept.keyframes.begin() || at == kept.keyframes.end()) continue;
    Entry e;
    e.series = series;
    set_motion(motion.over((at - 1)->t_ns, at->t_ns), &e);
    e.cause[static_cast<int>(Cause::time)] = 1e-9 * static_cast<double>(r.t_ns - zero_ns);
    e.cause[static_cast<int>(Cause::speed)] = at->v_GI.norm();
    for (int i = 0; i < 3; ++i) {
      e.value = r.rotation(i);
      append(e, false, motion.has_temperature(), &gyro[i]);
      e.value = r.velocity(i);
      append(e, false, motion.has_temperature(), &accel[i]);
    }
  }
}

}  // namespace

const char* words_of(Cause cause) { return kCauseWords[static_cast<int>(cause)].words; }
const char* unit_of(Cause cause) { return kCauseWords[static_cast<int>(cause)].unit; }

std::vector<SeenPoint> seen_points(const CoreKept& kept) {
  std::vector<SeenPoint> out;
  auto residual = kept.points.begin();
  for (const CorePoint& p : kept.measured) {
    if (residual == kept.points.end()) break;
    if (p.rejected || residual->camera != p.camera || residual->t_ns != kept.keyframes[p.keyframe].t_ns) continue;
    out.push_back({&p, &*residual++});
  }
  return out;
}

std::vector<ResidualList> residual_lists(const std::vector<CoreKept>& kept, const CoreModel& model,
                                         const Calibration& calibration, const std::vector<ImuData>& imu) {
  std::vector<ResidualList> out;
  for (const char* axis : {"u", "v", "radial"}) out.push_back({"camera", axis, {}, {}, {}});
  for (const char* sensor : {"gyro", "accel"}) {
    for (const char* axis : {"x", "y", "z"}) out.push_back({sensor, axis, {}, {}, {}});
  }
  if (kept.empty()) return out;
  const RawMotion motion(imu);
  const Vector2d middle = middle_of(kept);
  std::int64_t zero_ns = kept.front().segment.start_ns;
  for (const CoreKept& k : kept) zero_ns = std::min(zero_ns, k.segment.start_ns);
  int series = 0, segment = 0;
  for (const CoreKept& k : kept) {
    add_camera(k, model, calibration, motion, middle, zero_ns, &series, &out[0], &out[1], &out[2]);
    add_imu(k, motion, zero_ns, segment++, &out[3], &out[6]);
  }
  return out;
}

SensorSquares sensor_squares(const std::vector<CoreKept>& kept) {
  SensorSquares out;
  for (const CoreKept& k : kept) {
    for (const CorePointResidual& r : k.points) out.camera += r.u_sigma * r.u_sigma + r.v_sigma * r.v_sigma;
    for (const CoreImuResidual& r : k.imu) {
      out.gyro += r.rotation.squaredNorm();
      out.accel += r.velocity.squaredNorm() + r.position.squaredNorm();
    }
    out.camera_count += 2 * static_cast<int>(k.points.size());
    out.gyro_count += 3 * static_cast<int>(k.imu.size());
    out.accel_count += 6 * static_cast<int>(k.imu.size());
  }
  return out;
}

}  // namespace host::diagnosis
