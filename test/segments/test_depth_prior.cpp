// The prior on a landmark's distance counts from where the camera is, not from the point that the landmark is written
// about; and image points at the lens' edge, from where a small step takes them out of the cost, are set aside.
#include <memory>

#include "../support/cases.h"
#include "../support/cast.h"
#include "../support/random.h"
#include "../support/synthetic_segments.h"
#include "segments/depth_prior.h"
#include "segments/segment_cost.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// Every landmark is seen first by camera 1, beside camera 0; every other landmark's first point is an outlier.
test::SyntheticSession session_of(std::uint32_t seed) {
  test::SyntheticOptions options;
  options.seed = seed;
  options.segments = 1;
  options.keyframes = 6;
  options.landmarks = 20;
  test::SyntheticSession session(options);
  Calibration<double>& theta = session.nominal;
  theta.n_cameras = 2;
  theta.camera[1] = theta.camera[0];
  theta.camera[1].p_CI += Vec3<double>(0.1, 0.02, -0.03);
  theta.camera[1].R_CI = so3_exp<double>(Vec3<double>(0.02, -0.03, 0.05)) * theta.camera[1].R_CI;
  Segment<double>& segment = *session.segments[0];
  for (int j = 0; j < segment.n_landmarks; ++j) {
    Observation& z = segment.observation[segment.first_observation[j]];
    z.camera = 1;
    z.rejected = j % 2 == 0 ? 1 : 0;
  }
  return session;
}

/// Landmark j of a copy whose entry i moves by d: the landmark, its keyframe's pose, the extrinsics.
double moved_residual(const test::SyntheticSession& session, int j, int i, double d) {
  Segment<double> segment = *session.segments[0];
  Calibration<double> theta = session.nominal;
  const DepthPrior<double> at = depth_prior(segment, j, segment.states.landmark[j], theta, session.model);
  State<double>& x = segment.states.x[at.keyframe];
  Vec3<double> by = Vec3<double>::Zero();
  by(i % 3) = d;
  if (i < 3) add_step(&segment.states.landmark[j], by.data());
  if (i >= 3 && i < 6) x.R_GI = x.R_GI * so3_exp<double>(by);
  if (i >= 6 && i < 9) x.p_GI += by;
  if (i >= 9 && i < 12) theta.camera[1].R_CI = so3_exp<double>(by) * theta.camera[1].R_CI;
  if (i >= 12) theta.camera[1].p_CI += by;
  return depth_prior(segment, j, segment.states.landmark[j], theta, session.model).r;
}

void test_rows() {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const test::SyntheticSession session = session_of(seed);
    const Segment<double>& segment = *session.segments[0];
    for (int j = 0; j < segment.n_landmarks; ++j) {
      const DepthPrior<double> prior =
          depth_prior(segment, j, segment.states.landmark[j], session.nominal, session.model);
      Vec<double, 15> row;
      row << prior.row.l, prior.row.pose, prior.row.extrinsics;
      for (int i = 0; i < 15; ++i) {
        const Id id = Id().add("check", "rows").add("seed", static_cast<int>(seed)).add("landmark", j).add("entry", i);
        const double h = 1e-6;
        const double slope = (moved_residual(session, j, i, h) - moved_residual(session, j, i, -h)) / (2 * h);
        // A central difference of 1e-6 of a function whose third derivative is below 1e3: 1e-9, and rounding of 1e-10.
        test::check_near(id, "slope", slope, row(i), 1e-7 * (1 + std::fabs(slope)));
      }
    }
  }
}

/// The same place written about another fixed point: the same prior. By rho alone it would be another.
void test_it_does_not_hang_on_the_fixed_point() {
  const test::SyntheticSession session = session_of(7);
  const Segment<double>& segment = *session.segments[0];
  test::Random random(11);
  for (int j = 0; j < segment.n_landmarks; ++j) {
    const Landmark<double>& l = segment.states.landmark[j];
    Landmark<double> other = l;
    other.o += Vec3<double>(random.normal(0.1), random.normal(0.1), random.normal(0.1));
    const Vec3<double> way = l.o + l.m / l.rho - other.o;
    other.m = way.normalized();
    other.rho = (l.rho > 0 ? 1 : -1) / way.norm();
    if (l.rho < 0) other.m = -other.m;
    const Id id = Id().add("check", "fixed_point").add("landmark", j);
    const double a = depth_prior_cost(segment, j, l, session.nominal, session.model);
    const double b = depth_prior_cost(segment, j, other, session.nominal, session.model);
    test::check_near(id, "cost", a, b, 1e-12 * (1 + a));
    test::check_true(id, "the fixed point did not move", std::fabs(other.rho - l.rho) > 1e-4 * std::fabs(l.rho));
  }
}

/// A landmark whose points are all outliers, for now: the prior takes its distance and leaves its direction, so that it
/// is where its points are when they come back.
template <class S>
void check_unseen() {
  const test::SyntheticSession session = session_of(3);
  auto segment = std::make_unique<Segment<S>>();
  test::cast<S>(*session.segments[0], segment.get());
  const Calibration<S> theta = test::cast<S>(session.nominal);
  for (int o = 0; o < segment->n_observations; ++o) segment->observation[o].rejected = 1;
  for (int j = 0; j < segment->n_landmarks; ++j) {
    Landmark<S> l = segment->states.landmark[j];
    const Vec3<S> m = l.m;
    for (int i = 0; i < 5; ++i) refine_landmark(*segment, j, theta, MeasurementModel<S>(), 2, &l);
    const Id id = Id().add("check", "unseen").type<S>().add("landmark", j);
    test::check_near(id, "cosine of the direction's change", 1, double(m.dot(l.m)), 1e-6);
  }
}

void test_a_landmark_that_no_point_sees() {
  check_unseen<double>();
  check_unseen<float>();
}

/// A lens that folds 46 degrees off its axis: points up to its edge have an image, the outermost are not used.
void test_points_at_the_edge_are_set_aside() {
  Calibration<double> theta = test::nominal_calibration(Distortion::radtan);
  theta.camera[0].distortion << -0.3, 0, 0, 0;  // r (1 - 0.3 r^2) grows up to r = 1.054
  Segment<double> segment;
  segment.n_keyframes = 1;
  segment.n_landmarks = segment.n_observations = 0;
  segment.states.x[0] = State<double>();
  segment.t_us[0] = 0;
  segment.states.x[0].R_GI = theta.camera[0].R_CI;  // the camera's axes are those of G, and it is in the origin
  segment.states.x[0].p_GI = segment.states.x[0].R_GI * (theta.camera[0].R_CI.transpose() * theta.camera[0].p_CI);
  segment.first_observation[0] = 0;
  const double radius[] = {0.2, 0.9, 1.0, 1.02, 1.025};  // growth of the image's radius: 0.96, 0.27, 0.1, 0.064, 0.054
  const int expected[] = {0, 0, 0, 1, 1};
  for (const double r : radius) {
    const int j = segment.n_landmarks++;
    segment.states.landmark[j] = {Vec3<double>::Zero(), Vec3<double>(r, 0, 1).normalized(), 0.3};
    Vec2<double> uv;
    TEST_ASSERT_TRUE(project(theta.camera[0], Vec3<double>(r, 0, 1), &uv));
    segment.observation[segment.n_observations++] = {float(uv.x()), float(uv.y()), std::uint16_t(j), 0, 0, 0};
    segment.first_observation[j + 1] = std::uint16_t(segment.n_observations);
  }
  for (const double walk : {0.0, 0.1}) {
    MeasurementModel<double> model;
    model.track_walk = walk;
    const Id id = Id().add("check", "edge").add("walk", walk);
    test::check_near(id, "marked", 2, mark_outliers(theta, model, 6.0, &segment), 0);
    for (int j = 0; j < segment.n_landmarks; ++j)
      test::check_near(Id(id).add("landmark", j), "set aside", expected[j], segment.observation[j].rejected, 0);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_rows);
  RUN_TEST(test_it_does_not_hang_on_the_fixed_point);
  RUN_TEST(test_a_landmark_that_no_point_sees);
  RUN_TEST(test_points_at_the_edge_are_set_aside);
  return UNITY_END();
}
