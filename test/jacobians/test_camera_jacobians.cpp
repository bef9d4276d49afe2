// Projection and reprojection: values and Jacobians of each camera model, two ways, at ordinary and at singular points.
#include <vector>

#include "../support/cast.h"
#include "../support/random.h"
#include "jacobian_check.h"
#include "jet_camera.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using Camera = CameraCalibration<double>;

/// Directions in C: the axis itself, next to it, ordinary, 60 degrees off, and of other lengths.
const Vec3<double> kPoints[] = {{0, 0, 1},        {1e-6, 0, 1},   {-1e-6, 2e-6, 1}, {1e-3, -2e-3, 1}, {0.1, 0.14, 1},
                                {0.12, 0.125, 1}, {0.4, -0.3, 1}, {-1.1, 0.6, 1},   {0.3, 1.7, 1},    {0, 0.02, 0.05}};
constexpr int kPointCount = sizeof kPoints / sizeof kPoints[0];

/// Directions that only an equidistant lens has: so many degrees from the axis, at this angle about it, of this length.
const Vec3<double> kWideAngles[] = {{76, 20, 1},  {78, 200, 3}, {79.9, 130, 1}, {80.3, 130, 0.2}, {85, 310, 1},
                                    {89, 45, 10}, {90, 0, 1},   {90, 90, 0.01}, {95, 250, 1},     {99.5, 100, 1}};
Vec3<double> direction(const Vec3<double>& at) {
  const double degrees = M_PI / 180, a = at[0] * degrees, b = at[1] * degrees;
  return at[2] * Vec3<double>(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
}

struct NamedCamera {
  const char* name;
  Camera camera;
};

Camera make_camera(Distortion model, const Vec<double, 4>& coefficients) {
  Camera camera;
  camera.model = model;
  camera.intrinsics << 256, 260, 322, 241;
  camera.distortion = coefficients;
  camera.R_CI = so3_exp<double>(Vec3<double>(1.2, -1.1, 1.3));
  camera.p_CI << 0.02, -0.03, 0.05;
  return camera;
}

/// Every model; fov also where its formula has 0/0 (w = 0), at small w and on both sides of each type's threshold.
std::vector<NamedCamera> cameras() {
  std::vector<NamedCamera> list;
  const double widths[] = {0, 1e-8, 1e-4, 0.05, 0.0999, 0.1001, 0.2999, 0.3001, 0.92, 1.6};
  const char* names[] = {"fov_0",      "fov_1e-8",   "fov_1e-4",   "fov_0.05", "fov_0.0999",
                         "fov_0.1001", "fov_0.2999", "fov_0.3001", "fov",      "fov_1.6"};
  for (int i = 0; i < 10; ++i) list.push_back({names[i], make_camera(Distortion::fov, {widths[i], 0, 0, 0})});
  list.push_back({"radtan", make_camera(Distortion::radtan, {-0.05, 0.008, 3e-4, -2e-4})});
  list.push_back({"pinhole", make_camera(Distortion::radtan, {0, 0, 0, 0})});
  list.push_back({"equidistant", make_camera(Distortion::equidistant, {-0.01, 0.04, -0.03, 0.006})});
  list.push_back({"equidistant_0", make_camera(Distortion::equidistant, {0, 0, 0, 0})});
  return list;
}

/// Columns of project(): direction 3, fx fy cx cy, coefficients. `count` of them are real for the model.
int projection_columns(const Camera& camera) { return 7 + camera.distortion_columns(); }

Eigen::VectorXd projection_sizes(const Camera& camera) {
  Eigen::VectorXd size(projection_columns(camera));
  size.setConstant(camera.model == Distortion::fov ? 0.5 : 0.1);
  size.head<7>() << 1, 1, 1, 256, 256, 256, 256;
  return size;
}

template <class S>
Eigen::VectorXd project_after(const Camera& camera, const Vec3<double>& h, const Eigen::VectorXd& step) {
  CameraCalibration<S> moved = test::cast<S>(camera);
  for (int i = 0; i < 4; ++i) moved.intrinsics(i) += S(step(3 + i));
  for (int i = 0; i < camera.distortion_columns(); ++i) moved.distortion(i) += S(step(7 + i));
  Vec2<S> uv;
  project<S>(moved, (h + step.head<3>()).cast<S>(), &uv);
  return uv.template cast<double>();
}

/// Jacobian by the core, direction and intrinsics side by side.
template <class S>
Eigen::MatrixXd analytic_projection(const Camera& camera, const Vec3<double>& h) {
  Vec2<S> uv;
  Mat<S, 2, 3> J_h;
  Mat<S, 2, kIntrinsicColumns> J_i;
  project<S>(test::cast<S>(camera), h.cast<S>(), &uv, &J_h, &J_i);
  Eigen::MatrixXd J(2, 3 + kIntrinsicColumns);
  J << J_h.template cast<double>(), J_i.template cast<double>();
  return J.leftCols(projection_columns(camera));
}

Eigen::MatrixXd automatic_projection(const Camera& camera, const Vec3<double>& h, Vec2<double>* uv) {
  using T = ceres::Jet<double, 11>;
  T k[8];
  for (int i = 0; i < 4; ++i) {
    k[i] = T(camera.intrinsics(i), 3 + i);
    k[4 + i] = T(camera.distortion(i), 7 + i);
  }
  const Eigen::Matrix<T, 2, 1> p = jet::project<T>(camera.model, k, {T(h[0], 0), T(h[1], 1), T(h[2], 2)});
  Eigen::MatrixXd J(2, 11);
  for (int r = 0; r < 2; ++r) {
    (*uv)(r) = p[r].a;
    J.row(r) = p[r].v.transpose();
  }
  return J.leftCols(projection_columns(camera));
}

template <class S>
void check_projection(const NamedCamera& model, const char* name, int point, const Vec3<double>& at) {
  const Id id = Id().add("model", model.name).template type<S>().add(name, point);
  // What S holds of the numbers, so that the automatic derivative in double is taken at the same place.
  const Camera camera = test::cast<double>(test::cast<S>(model.camera));
  const Vec3<double> h = at.cast<S>().template cast<double>();
  Vec2<double> expected;
  const Eigen::MatrixXd automatic = automatic_projection(camera, h, &expected);
  const Eigen::MatrixXd J = analytic_projection<S>(camera, h);
  // Pixels near 600 in float are 6e-5 apart; a few operations more.
  const double pixel_tolerance = std::is_same<S, float>::value ? 3e-4 : 1e-10;
  const Eigen::VectorXd uv = project_after<S>(camera, h, Eigen::VectorXd::Zero(J.cols()));
  test::check_near(id, "pixel", 0, (uv - expected).norm(), pixel_tolerance);
  test::check_automatic<S>(id.add("by", "jet"), J, automatic, 1.0);
  // A step of a direction must stay small beside the direction itself.
  Eigen::VectorXd size = projection_sizes(camera);
  size.head<3>() *= h.norm();
  const auto f = [&](const Eigen::VectorXd& step) { return project_after<S>(camera, h, step); };
  test::check_differences<S>(id.add("by", "differences"), J, size, f);
}

/// A scene for reprojection: pose, landmark.
struct Scene {
  const char* name;
  Mat3<double> R_GI;
  Vec3<double> p_GI;
  double rho;
  Vec2<double> off_axis;  ///< where the landmark stands in the image, normalised
  Mat3<double> R_CI;
};

std::vector<Scene> scenes() {
  const Mat3<double> I = Mat3<double>::Identity();
  const Mat3<double> R = so3_exp<double>(Vec3<double>(0.4, -1.2, 2.1)),
                     tiny = so3_exp<double>(Vec3<double>(1e-8, -1e-8, 1e-8));
  const Mat3<double> C = so3_exp<double>(Vec3<double>(1.2, -1.1, 1.3));
  const Vec3<double> p(0.3, -0.8, 1.2), zero(0, 0, 0);
  return {{"ordinary", R, p, 0.4, {0.3, -0.2}, C},    {"near", R, p, 2.5, {-0.2, 0.4}, C},
          {"direction", R, p, 0, {0.3, -0.2}, C},     {"almost_direction", R, p, 1e-7, {0.3, -0.2}, C},
          {"identity", I, zero, 0.4, {0.3, -0.2}, I}, {"tiny_rotation", tiny, zero, 0.4, {0.1, 0.2}, tiny},
          {"centre", R, p, 0.4, {0, 0}, C},           {"near_centre", R, p, 0.4, {1e-6, -1e-6}, C},
          {"centre_direction", I, zero, 0, {0, 0}, I}};
}

/// A landmark that stands at the scene's place in the image, seen first from half a metre away.
Landmark<double> make_landmark(const Scene& scene, const Camera& camera) {
  Landmark<double> l;
  l.o = scene.p_GI + Vec3<double>(0.3, -0.2, 0.35);
  l.rho = scene.rho;
  const Vec3<double> h(scene.off_axis.x(), scene.off_axis.y(), 1);
  const Vec3<double> in_G = scene.R_GI * (camera.R_CI.transpose() * (h - scene.rho * camera.p_CI));
  l.m = in_G - scene.rho * (l.o - scene.p_GI);
  const double n = l.m.norm();
  l.m /= n;
  l.rho /= n;
  return l;
}

template <class S>
Eigen::VectorXd reproject_after(const Camera& camera, const State<double>& x, const Landmark<double>& l,
                                const Eigen::VectorXd& step) {
  Calibration<S> theta;
  theta.camera[0] = test::cast<S>(camera);
  S theta_step[kMaxTheta] = {}, state_step[kStateColumns] = {}, landmark_step[3];
  for (int i = 0; i < camera.columns(); ++i) theta_step[i] = S(step(9 + i));
  for (int i = 0; i < 6; ++i) state_step[i] = S(step(3 + i));
  for (int i = 0; i < 3; ++i) landmark_step[i] = S(step(i));
  add_step(&theta, theta_step);
  State<S> moved = test::cast<S>(x);
  moved.add(state_step);
  Landmark<S> landmark = test::cast<S>(l);
  add_step(&landmark, landmark_step);
  Vec2<S> r;
  reprojection_residual<S>(theta.camera[0], moved.R_GI, moved.p_GI, landmark, Vec2<S>::Zero(), &r);
  return r.template cast<double>();
}

template <class S>
Eigen::MatrixXd analytic_reprojection(const Camera& camera, const State<double>& x, const Landmark<double>& l) {
  const State<S> state = test::cast<S>(x);
  ReprojectionRows<S> rows;
  const bool seen = reprojection_rows<S>(test::cast<S>(camera), state.R_GI, state.p_GI, state.R_GI, state.p_GI,
                                         test::cast<S>(l), Vec2<S>::Zero(), &rows);
  TEST_ASSERT_TRUE(seen);
  Eigen::MatrixXd J(2, jet::kReprojectionColumns);
  J << rows.J_l.template cast<double>(), rows.J_pose.template cast<double>(), rows.J_camera.template cast<double>();
  return J.leftCols(9 + camera.columns());
}

Eigen::MatrixXd automatic_reprojection(const Camera& camera, const State<double>& x, const Landmark<double>& l) {
  using T = ceres::Jet<double, jet::kReprojectionColumns>;
  T step[jet::kReprojectionColumns];
  for (int i = 0; i < jet::kReprojectionColumns; ++i) step[i] = T(0.0, i);
  const Eigen::Matrix<T, 2, 1> p = jet::predict<T>(camera, x.R_GI, x.p_GI, l, step);
  Eigen::MatrixXd J(2, jet::kReprojectionColumns);
  for (int r = 0; r < 2; ++r) J.row(r) = p[r].v.transpose();
  return J.leftCols(9 + camera.columns());
}

Eigen::VectorXd reprojection_sizes(const Camera& camera) {
  Eigen::VectorXd size = Eigen::VectorXd::Ones(9 + camera.columns());
  // Metres beside a landmark that may be 0.4 m away.
  size.segment<3>(6).setConstant(0.4);
  size.segment<3>(12).setConstant(0.4);
  size.tail(camera.columns() - 6) = projection_sizes(camera).tail(camera.columns() - 6);
  return size;
}

template <class S>
void check_reprojection(const NamedCamera& model, const Scene& scene) {
  const Id id = Id().add("model", model.name).template type<S>().add("scene", scene.name);
  Camera camera = model.camera;
  camera.R_CI = scene.R_CI;
  State<double> x;
  x.R_GI = scene.R_GI;
  x.p_GI = scene.p_GI;
  Landmark<double> l = make_landmark(scene, camera);
  camera = test::cast<double>(test::cast<S>(camera));
  x = test::cast<double>(test::cast<S>(x));
  l = test::cast<double>(test::cast<S>(l));
  const Eigen::MatrixXd J = analytic_reprojection<S>(camera, x, l);
  test::check_automatic<S>(id.add("by", "jet"), J, automatic_reprojection(camera, x, l), 1.0);
  const auto f = [&](const Eigen::VectorXd& step) { return reproject_after<S>(camera, x, l, step); };
  test::check_differences<S>(id.add("by", "differences"), J, reprojection_sizes(camera), f);
}

template <class S>
void check_all_projections() {
  for (const NamedCamera& camera : cameras()) {
    for (int point = 0; point < kPointCount; ++point) check_projection<S>(camera, "point", point, kPoints[point]);
    if (camera.camera.model != Distortion::equidistant) continue;
    for (const Vec3<double>& at : kWideAngles)
      check_projection<S>(camera, "wide", static_cast<int>(&at - kWideAngles), direction(at));
  }
}

template <class S>
void check_all_reprojections() {
  for (const NamedCamera& camera : cameras()) {
    for (const Scene& scene : scenes()) check_reprojection<S>(camera, scene);
  }
}

template <class S>
void check_unproject() {
  for (const NamedCamera& model : cameras()) {
    for (int point = 0; point < kPointCount; ++point) {
      const Vec2<double> xy = kPoints[point].head<2>() / kPoints[point].z();
      const Eigen::VectorXd uv = project_after<S>(model.camera, kPoints[point], Eigen::VectorXd::Zero(11));
      Vec3<S> back;
      const Id id = Id().add("model", model.name).template type<S>().add("point", point).add("by", "unproject");
      test::check_true(id, "did not converge", unproject<S>(test::cast<S>(model.camera), uv.cast<S>(), &back));
      // A pixel in float is good to 3e-5 px of 256 px, more where the model compresses the image's border.
      test::check_near(
          id, "normalised point", 0, ((back.template head<2>() / back.z()).template cast<double>() - xy).norm(),
          (std::is_same<S, float>::value ? 2e-6 : 1e-11) * (1 + xy.squaredNorm()) * (1 + xy.squaredNorm()));
    }
  }
}

/// Back to the direction, over all of the sphere that the lens sees, to an angle: a pixel in float is good to 6e-5 px
/// of 256 px a radian, and these lenses have 0.7 of that and more at their edge.
template <class S>
void check_wide_unproject() {
  for (const NamedCamera& model : cameras()) {
    if (model.camera.model != Distortion::equidistant) continue;
    for (const Vec3<double>& at : kWideAngles) {
      const Vec3<double> h = direction(at);
      const Eigen::VectorXd uv = project_after<S>(model.camera, h, Eigen::VectorXd::Zero(11));
      Vec3<S> back;
      const Id id = Id().add("model", model.name).template type<S>().add("angle", at[0]).add("by", "unproject");
      test::check_true(id, "did not converge", unproject<S>(test::cast<S>(model.camera), uv.cast<S>(), &back));
      test::check_near(id, "direction", 0, (back.template cast<double>() - h.normalized()).norm(),
                       std::is_same<S, float>::value ? 3e-6 : 1e-12);
    }
  }
}

void test_wide_angles_and_back() {
  check_wide_unproject<float>();
  check_wide_unproject<double>();
}

/// 100 degrees from the axis is the end, or where the lens folds back: k1 = -0.2 at 74 degrees. Two degrees before, a
/// point counts as at the edge.
void test_the_end_of_a_wide_lens() {
  Camera camera = make_camera(Distortion::equidistant, {0, 0, 0, 0});
  Vec2<double> uv;
  TEST_ASSERT_TRUE(project<double>(camera, direction({99.9, 30, 1}), &uv));
  TEST_ASSERT_FALSE(project<double>(camera, direction({100.1, 30, 1}), &uv));
  TEST_ASSERT_TRUE(well_inside<double>(camera, direction({97.5, 30, 1})));
  TEST_ASSERT_FALSE(well_inside<double>(camera, direction({98.5, 30, 1})));
  camera.distortion(0) = -0.2;
  TEST_ASSERT_TRUE(project<double>(camera, direction({70, 30, 1}), &uv));
  TEST_ASSERT_FALSE(project<double>(camera, direction({75, 30, 1}), &uv));
  for (Distortion model : {Distortion::fov, Distortion::radtan}) {
    camera = make_camera(model, {0.001, 0, 0, 0});
    TEST_ASSERT_TRUE(project<double>(camera, direction({79, 30, 1}), &uv) || model == Distortion::fov);
    TEST_ASSERT_FALSE(project<double>(camera, direction({81, 30, 1}), &uv));
  }
}

void test_projection() {
  check_all_projections<float>();
  check_all_projections<double>();
}

void test_reprojection() {
  check_all_reprojections<float>();
  check_all_reprojections<double>();
}

void test_unproject_inverts_project() {
  check_unproject<float>();
  check_unproject<double>();
}

void test_points_without_image() {
  const Camera camera = make_camera(Distortion::radtan, {-0.3, 0, 0, 0});
  Vec2<double> uv;
  TEST_ASSERT_FALSE(project<double>(camera, {0, 0, -1}, &uv));
  TEST_ASSERT_FALSE(project<double>(camera, {0, 0, 0}, &uv));
  TEST_ASSERT_FALSE(project<double>(camera, {10, 0, 1}, &uv));
  // k1 = -0.3 folds back at r = 1.05.
  TEST_ASSERT_TRUE(project<double>(camera, {0.9, 0, 1}, &uv));
  TEST_ASSERT_FALSE(project<double>(camera, {1.1, 0, 1}, &uv));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_projection);
  RUN_TEST(test_reprojection);
  RUN_TEST(test_unproject_inverts_project);
  RUN_TEST(test_points_without_image);
  RUN_TEST(test_wide_angles_and_back);
  RUN_TEST(test_the_end_of_a_wide_lens);
  return UNITY_END();
}
