// Triangulation: exact points come back, tracks without parallax become directions, impossible ones are refused.
#include <memory>

#include "../support/cases.h"
#include "../support/cast.h"
#include "../support/random.h"
#include "../support/synthetic_segments.h"
#include "segments/segment_cost.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// A segment of `keyframes` poses with one landmark, seen without noise.
struct Scene {
  Calibration<double> theta = test::nominal_calibration(Distortion::radtan);
  std::unique_ptr<Segment<double>> segment = std::make_unique<Segment<double>>();
  explicit Scene(int keyframes) {
    segment->n_keyframes = keyframes;
    segment->n_landmarks = 1;
    segment->n_observations = 0;
    segment->first_observation[0] = segment->first_observation[1] = 0;
  }
  void add_pose(int k, const Mat3<double>& R_GC, const Vec3<double>& camera_in_G) {
    State<double>& x = segment->states.x[k];
    x = State<double>();
    x.R_GI = R_GC * theta.camera[0].R_CI;
    x.p_GI = camera_in_G + x.R_GI * (theta.camera[0].R_CI.transpose() * theta.camera[0].p_CI);
  }
  Vec3<double> in_camera(int k, const Vec3<double>& l) const {
    const State<double>& x = segment->states.x[k];
    return theta.camera[0].R_CI * (x.R_GI.transpose() * (l - x.p_GI)) + theta.camera[0].p_CI;
  }
  void see_pixel(int k, const Vec2<double>& uv) {
    segment->observation[segment->n_observations++] = {float(uv.x()), float(uv.y()), 0, std::uint8_t(k), 0, 0};
    segment->first_observation[1] = static_cast<std::uint16_t>(segment->n_observations);
  }
  void see(int k, const Vec3<double>& l) {
    Vec2<double> uv;
    TEST_ASSERT_TRUE(project(theta.camera[0], in_camera(k, l), &uv));
    see_pixel(k, uv);
  }
  Landmark<double>& landmark() { return segment->states.landmark[0]; }
};

Mat3<double> look(double yaw) { return so3_exp<double>(Vec3<double>(0, yaw, 0)); }

template <class S>
bool run(Scene* scene, Landmark<double>* out, double limit = 4) {
  auto segment = std::make_unique<Segment<S>>();
  test::cast<S>(*scene->segment, segment.get());
  const bool good = triangulate<S>(segment.get(), 0, test::cast<S>(scene->theta), MeasurementModel<S>(), S(limit));
  *out = test::cast<double>(segment->states.landmark[0]);
  return good;
}

template <class S>
void check_exact() {
  for (double depth : {0.4, 1.0, 4.0, 15.0}) {
    Scene scene(5);
    const Vec3<double> l(0.2 * depth, -0.1 * depth, depth);
    for (int k = 0; k < 5; ++k) {
      scene.add_pose(k, look(0.02 * k), Vec3<double>(0.06 * k, 0.02 * k, -0.01 * k));
      scene.see(k, l);
    }
    Landmark<double> found;
    const Id id = Id().add("check", "exact").type<S>().add("depth", depth);
    test::check_true(id, "refused", run<S>(&scene, &found));
    const Vec3<double> point = found.o + found.m / found.rho;
    // Parallax at depth d from a base of 0.25 m: an error e of inverse depth is 64
    // e px of parallax. Image points are floats (3e-5 px); the prior on the inverse
    // depth (2 per metre) pulls by rho / (2 * 128)^2 of rho, four points here.
    test::check_near(id, "inverse depth", 1 / (l - found.o).norm(), found.rho, 2e-5 * (1 + 1 / depth));
    test::check_near(id, "direction", 0, (found.m - (l - found.o).normalized()).norm(), 1e-5);
    test::check_near(id, "point", 0, (point - l).norm() / l.norm(), 3e-5 * (1 + depth));
  }
}

template <class S>
void check_rotation_in_place() {
  // The camera turns about its own centre: no parallax at all. With noise of half a pixel.
  for (int seed = 0; seed < 20; ++seed) {
    test::Random random(51 + seed);
    Scene scene(6);
    for (int k = 0; k < 6; ++k) {
      scene.add_pose(k, look(0.08 * k - 0.2), Vec3<double>::Zero());
      Vec2<double> uv;
      TEST_ASSERT_TRUE(project(scene.theta.camera[0], scene.in_camera(k, Vec3<double>(0.3, 0.2, 3)), &uv));
      scene.see_pixel(k, uv + Vec2<double>(random.normal(0.5), random.normal(0.5)));
    }
    Landmark<double> found;
    const Id id = Id().add("check", "in_place").type<S>().add("seed", seed);
    test::check_true(id, "refused", run<S>(&scene, &found));
    test::check_near(id, "direction", 0, (found.m - Vec3<double>(0.3, 0.2, 3).normalized()).norm(), 0.01);
    test::check_true(id, "finite", is_finite(found.rho));
    // Nothing tells the distance: the prior (zero) alone speaks. Positions rounded to 3e-8 m (float) shift an image by
    // 1.5e-5 sigma per 1/m; twelve noisy coordinates and the prior's variance of 4 make up to 2e-4 of that.
    test::check_near(id, "rho", 0, found.rho, 1e-3);
  }
}

template <class S>
void check_far_point() {
  // A star: 10 km away behind half a metre of motion.
  Scene scene(5);
  for (int k = 0; k < 5; ++k) {
    scene.add_pose(k, look(0), Vec3<double>(0.12 * k, 0, 0));
    scene.see(k, Vec3<double>(1000, 500, 10000));
  }
  Landmark<double> found;
  const Id id = Id().add("check", "far").type<S>();
  test::check_true(id, "refused", run<S>(&scene, &found));
  test::check_near(id, "rho", 1e-4, found.rho, 2e-5);
}

template <class S>
void check_refused() {
  const Id id = Id().add("check", "refused").type<S>();
  Landmark<double> found;
  // Rays that part would meet behind the cameras: never a point in front of them.
  Scene behind(3);
  for (int k = 0; k < 3; ++k) {
    behind.add_pose(k, look(0), Vec3<double>(0.3 * k, 0, 0));
    behind.see_pixel(k, Vec2<double>(320 + 40 * k, 240));
  }
  test::check_true(id.add("why", "behind"), "a point in front", !run<S>(&behind, &found) || found.rho <= 0);
  // Rays that pass each other: a track that jumped to another corner.
  Scene skew(4);
  for (int k = 0; k < 4; ++k) {
    skew.add_pose(k, look(0), Vec3<double>(0.1 * k, 0, 0));
    skew.see_pixel(k, Vec2<double>(320 - 10 * k, k < 2 ? 240 : 280));
  }
  test::check_true(id.add("why", "jump"), "accepted", !run<S>(&skew, &found));
  test::check_true(id.add("why", "jump"), "finite", found.m.allFinite() && is_finite(found.rho));
}

/// Where tracks drift, the rows that triangulation solves are the slope of the cost that the calibration judges steps
/// by, also with a point far off and a slip.
void test_drifting_rows_are_the_slope_of_the_cost() {
  test::SyntheticOptions options;
  options.seed = 61;
  options.segments = 1;
  options.landmarks = 20;
  options.track_walk = 0.9;
  test::SyntheticSession session(options);
  Segment<double>& segment = *session.segments[0];
  for (int j = 0; j < segment.n_landmarks; ++j) {
    const int middle = (segment.first_observation[j] + segment.first_observation[j + 1]) / 2;
    segment.observation[middle].v += 6;
    for (int o = middle; o < segment.first_observation[j + 1]; ++o) segment.observation[o].u += 3;
    const Landmark<double> l = segment.states.landmark[j];
    double data[packed_size(4)];
    const Id id = Id().add("check", "slope").add("landmark", j);
    const double cost = landmark_cost<double>(segment, j, session.nominal, session.model, l, data);
    test::check_near(id, "cost", image_cost(segment, j, TiedLandmarks(), session.nominal, session.model), cost,
                     1e-9 * cost);
    const PackedTriangle<double> R(data, 4);
    for (int c = 0; c < 3; ++c) {
      double slope = 0, at[2];
      for (int i = 0; i <= c; ++i) slope -= 2 * R(i, c) * R(i, 3);
      const double h = 1e-6;
      for (int side = 0; side < 2; ++side) {
        double d[3] = {};
        d[c] = side == 0 ? -h : h;
        segment.states.landmark[j] = l;
        add_step(&segment.states.landmark[j], d);
        at[side] = image_cost(segment, j, TiedLandmarks(), session.nominal, session.model);
      }
      segment.states.landmark[j] = l;
      // Robust weights settle to 1e-14 of the cost, some 1e4: 1e-10 over a step of 2e-6.
      test::check_near(id.add("column", c), "slope", slope, (at[1] - at[0]) / (2 * h), 1e-3 + 1e-5 * std::fabs(slope));
    }
  }
}

void test_exact_points() {
  check_exact<float>();
  check_exact<double>();
}
void test_rotation_in_place_gives_directions() {
  check_rotation_in_place<float>();
  check_rotation_in_place<double>();
}
void test_far_points() {
  check_far_point<float>();
  check_far_point<double>();
}
void test_impossible_tracks() {
  check_refused<float>();
  check_refused<double>();
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_exact_points);
  RUN_TEST(test_drifting_rows_are_the_slope_of_the_cost);
  RUN_TEST(test_rotation_in_place_gives_directions);
  RUN_TEST(test_far_points);
  RUN_TEST(test_impossible_tracks);
  return UNITY_END();
}
