// Terms of effects: every column of a link and of an image point, two ways (central differences of the core's own
// prediction, automatic derivatives of a model written a second time), in float and double.
#include <ceres/jet.h>

#include <memory>

#include "../support/cast.h"
#include "../support/path.h"
#include "jacobian_check.h"
#include "jet_imu.h"
#include "segments/exposure.h"
#include "sensors/effect_catalogue.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

const Vec3<double> kGravity(0, 0, -9.80665);
constexpr double kDt = 0.005;

/// All terms: the catalogue's, and some of a dictionary.
std::vector<Term> terms(bool of_imu) {
  std::vector<Term> out;
  for (int e = 0; e < kEffects; ++e) {
    for (int i = 0; i < effect_entry(e).n; ++i) {
      if (effect_term(e, i).of_imu() == of_imu) out.push_back(effect_term(e, i));
    }
  }
  const auto s = [](Signal x) { return static_cast<std::uint8_t>(x); };
  if (of_imu) {
    out.push_back({TermKind::gyro_y, s(Signal::fy), s(Signal::wz), 0});
    out.push_back({TermKind::gyro_z, s(Signal::abs_w), s(Signal::dwx), 0});
    out.push_back({TermKind::accel_x, s(Signal::fz), s(Signal::wy), 0});
    out.push_back({TermKind::accel_z, s(Signal::time), s(Signal::warmth), 0});
    out.push_back({TermKind::accel_y, s(Signal::cos_heading), s(Signal::wx), 0});
    out.push_back({TermKind::gyro_x, s(Signal::sin_heading), s(Signal::one), 0});
  } else {
    out.push_back({TermKind::image_u, 2, 1, 0});
    out.push_back({TermKind::image_v, 0, 3, 1});
  }
  return out;
}

std::string name_of(const Term& t) {
  return std::to_string(int(t.kind)) + "." + std::to_string(t.a) + "." + std::to_string(t.b) + "." +
         std::to_string(t.c);
}

test::Path path() {
  test::Random random(3);
  return test::random_path(&random, 1, 1);
}

/// A segment of two keyframes 0.2 s apart with samples well beyond both, on a known path.
std::unique_ptr<Segment<double>> make_segment() {
  auto s = std::make_unique<Segment<double>>();
  s->t0_ns = 1000000000;
  s->n_keyframes = 2;
  s->t_us[0] = 0;
  s->t_us[1] = 200000;
  s->warmth[0] = 4;
  s->warmth[1] = 4.5f;
  s->imu.clear();
  const ImuCalibration<double> imu;
  for (int i = -20; i <= 60; ++i) {
    s->imu.push(i * 5000, measure(path(), imu, Vec3<double>::Zero(), Vec3<double>::Zero(), 1 + i * kDt));
  }
  for (int k = 0; k < 2; ++k) s->states.x[k] = path().state(1 + s->t_us[k] * 1e-6);
  return s;
}

// ---- IMU terms by automatic derivatives: the integral of test/jacobians/jet_imu.h with one term of value c ----

using J1 = ceres::Jet<double, 1>;
using V3 = jet::V3<J1>;

Vec2<double> heading(const State<double>& x) { return x.R_GI.topLeftCorner<2, 1>().normalized(); }

/// What the term adds to gyroscope and accelerometer, in words of the design's table and not of the core's products.
void add_term(const Term& t, const Vec3<double>& w, const Vec3<double>& f, const Vec3<double>& slope, double warmth,
              double time, const Vec2<double>& heading, Vec3<double>* gyro, Vec3<double>* accel) {
  int e = -1, i = 0;
  if (find_effect(t, &e, &i)) {
    const int axis = i % 3;
    const Vec3<double> unit = Vec3<double>::Unit(axis);
    switch (e) {
      case 4: (*gyro)(i / 3) += f(axis); return;
      case 5: (*gyro)(axis) += w(axis) * std::fabs(w(axis)); return;
      case 6: (*accel)(axis) += f(axis) * f(axis); return;
      case 7: (*gyro)(axis) += warmth; return;
      case 8: (*accel)(axis) += warmth; return;
      case 9: *gyro -= slope; return;
      default: (*accel)(1 + i / 3) += (slope.cross(unit) + w.cross(w.cross(unit)))(1 + i / 3); return;
    }
  }
  if (t.kind == TermKind::gyro_y) gyro->y() += f.y() * w.z();
  if (t.kind == TermKind::gyro_z) gyro->z() += w.norm() * slope.x();
  if (t.kind == TermKind::accel_x) accel->x() += f.z() * w.y();
  if (t.kind == TermKind::accel_z) accel->z() += time * warmth;
  if (t.kind == TermKind::accel_y) accel->y() += heading.x() * w.x();
  if (t.kind == TermKind::gyro_x) gyro->x() += heading.y();
}

/// The term's column of the link's rotation, velocity and position, at value zero.
Eigen::MatrixXd automatic_link(const Segment<double>& s, const Term& term) {
  const auto sample = [&](int i, V3* w, V3* f) {
    const InertialReading<double> r = corrected_reading<double>(s.imu, i), raw = s.imu.reading(i);
    const Vec3<double> slope = (s.imu.reading(i + 1).gyro - s.imu.reading(i - 1).gyro) / (2 * kDt);
    const double u = (s.imu.time(i) - s.t_us[0]) * 1e-6 / 0.2;
    Vec3<double> gyro = Vec3<double>::Zero(), accel = gyro;
    add_term(term, r.gyro, r.accel, slope, s.warmth[0] + u * (double(s.warmth[1]) - s.warmth[0]), 1 + 0.2 * u,
             heading(path().state(1 + s.imu.time(i) * 1e-6)), &gyro, &accel);
    for (int k = 0; k < 3; ++k) {
      (*w)(k) = J1(r.gyro(k));
      (*f)(k) = J1(r.accel(k));
      (*w)(k).v(0) = -gyro(k);
      (*f)(k).v(0) = -accel(k);
    }
    (void)raw;
  };
  Eigen::Quaternion<J1> q = Eigen::Quaternion<J1>::Identity();
  V3 v = V3::Zero(), p = V3::Zero(), w, f, w1, f1;
  const J1 h(kDt);
  sample(20, &w, &f);
  for (int i = 21; i <= 60; ++i) {
    sample(i, &w1, &f1);
    const V3 wm = (w + w1) / J1(2), fm = (f + f1) / J1(2);
    const V3 turn_m = (w + wm) * (h / J1(4)) + w.cross(wm) * (h * h / J1(48));
    const V3 turn = wm * h + w.cross(w1) * (h * h / J1(12));
    const V3 a = q * f, am = (q * jet::exponential(turn_m.data())) * fm;
    q = q * jet::exponential(turn.data());
    const V3 a1 = q * f1;
    p += v * h + (a + J1(2) * am) * (h * h / J1(6));
    v += (a + J1(4) * am + a1) * (h / J1(6));
    w = w1;
    f = f1;
  }
  Eigen::Quaternion<J1> q0(J1(q.w().a), J1(q.x().a), J1(q.y().a), J1(q.z().a));
  const V3 turned = jet::logarithm<J1>(q0.conjugate() * q);
  Eigen::MatrixXd out(9, 1);
  for (int k = 0; k < 3; ++k) out(k) = turned(k).v(0), out(3 + k) = v(k).v(0), out(6 + k) = p(k).v(0);
  return out;
}

template <class S>
ImuIntegral<S> integral(const Segment<S>& s, const Term* term, double value, ImuTermColumns<S>* columns) {
  Calibration<S> theta;
  if (term) theta.effects.add(*term, S(value));
  return s.integrate(1, theta, Vec3<S>::Zero(), Vec3<S>::Zero(), ImuNoise<S>(), columns);
}

template <class S>
Eigen::MatrixXd analytic_link(const Segment<S>& s, const Term& term, double value) {
  static ImuTermColumns<S> columns;
  columns.n = 1;
  columns.term[0] = term;
  integral<S>(s, &term, value, &columns);
  Eigen::MatrixXd out(9, 1);
  for (int k = 0; k < 3; ++k) {
    out(k) = double(columns.J_R[0](k));
    out(3 + k) = double(columns.J_v[0](k));
    out(6 + k) = double(columns.J_p[0](k));
  }
  return out;
}

/// By how much the integral moves when the term goes from `at` to `at` + `step`.
template <class S>
Eigen::VectorXd moved_link(const Segment<S>& s, const Term& term, double at, double step) {
  const ImuIntegral<S> I0 = integral<S>(s, &term, at, nullptr), I = integral<S>(s, &term, at + step, nullptr);
  Eigen::VectorXd out(9);
  out << so3_log<S>(I0.dR.transpose() * I.dR).template cast<double>(), I.dv.template cast<double>(),
      I.dp.template cast<double>();
  return out;
}

/// Blocks of rotation, velocity and position have units of their own.
template <class S>
void check_blocks(const Id& id, const Eigen::MatrixXd& J, const Eigen::MatrixXd& expected, double tolerance,
                  double rounding) {
  for (int row = 0; row < 9; ++row) {
    const double size = expected.middleRows(row / 3 * 3, 3).cwiseAbs().maxCoeff();
    test::check_near(id.add("row", row), "column", expected(row), J(row), tolerance * size + rounding);
  }
}

template <class S>
void check_link_terms() {
  const auto original = make_segment();
  auto single = std::make_unique<Segment<S>>();
  test::cast<S>(*original, single.get());
  auto same = std::make_unique<Segment<double>>();
  test::cast<double>(*single, same.get());
  for (const Term& term : terms(true)) {
    const Id id = Id().add("term", name_of(term)).template type<S>();
    const Eigen::MatrixXd J = analytic_link<S>(*single, term, 0);
    // Forty steps of some dozens of operations. The samples' 16 bits are the same for both.
    // The path's heading against the integral's, from samples of 16 bits, extrapolated over one sample, (w dt)^2 / 2,
    // where I's x axis is steep: 5e-4.
    const bool heading = term.a == int(Signal::cos_heading) || term.a == int(Signal::sin_heading);
    check_blocks<S>(id.add("by", "jet"), J, automatic_link(*same, term),
                    test::kAutomaticTolerance<S> * 10 + (heading ? 5e-4 : 0), 0);
    // The step is worth 1e-3 of a typical reading in double; the term is linear but for its fixed point, which the
    // difference cancels to the third order. Float needs a larger one: 5e-7 of 2 m/s over a step of 1 %.
    const double h = (std::is_same<S, float>::value ? 0.2 : 0.01) * term_prior_sigma(term);
    const Eigen::MatrixXd numeric =
        (moved_link<S>(*single, term, 0, h) - moved_link<S>(*single, term, 0, -h)) / (2 * h);
    const double rounding = 8 * double(std::numeric_limits<S>::epsilon()) * 2 / h;
    check_blocks<S>(id.add("by", "differences"), J, numeric, std::is_same<S, float>::value ? 3e-3 : 1e-5, rounding);
  }
}

/// Away from zero a column leaves out how phi itself moves: a
/// share |d e / d(w, f)| of it, here below 2 % for every term.
void test_link_terms_away_from_zero() {
  const auto s = make_segment();
  for (const Term& term : terms(true)) {
    const double value = 0.3 * term_prior_sigma(term), h = 0.01 * term_prior_sigma(term);
    const Eigen::MatrixXd J = analytic_link<double>(*s, term, value);
    const Eigen::MatrixXd numeric =
        (moved_link<double>(*s, term, value, h) - moved_link<double>(*s, term, value, -h)) / (2 * h);
    check_blocks<double>(Id().add("term", name_of(term)).add("value", value), J, numeric, 2e-2, 1e-9);
  }
}

void test_link_terms_in_double() { check_link_terms<double>(); }
void test_link_terms_in_float() { check_link_terms<float>(); }

// ---- camera ----

CameraCalibration<double> lens(double middle_line = 240) {
  CameraCalibration<double> camera;
  camera.middle_line = middle_line;
  camera.model = Distortion::radtan;
  camera.intrinsics << 256, 258, 322, 239;
  camera.distortion << -0.05, 0.01, 1e-3, -2e-3;
  camera.R_CI << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  camera.p_CI << 0.02, -0.03, 0.05;
  return camera;
}

/// A landmark in the image's lower left as keyframe 1 sees it, and the point's row.
void place_landmark(Segment<double>* s, Landmark<double>* l, Observation* z) {
  const State<double>& x = s->states.x[1];
  const CameraCalibration<double> camera = lens();
  const Vec3<double> in_C = 2.5 * Vec3<double>(-0.6, 0.5, 1).normalized();
  const Vec3<double> in_G = x.p_GI + x.R_GI * (camera.R_CI.transpose() * (in_C - camera.p_CI));
  l->o = x.p_GI + Vec3<double>(0.3, -0.2, 0.1);
  l->m = (in_G - l->o).normalized();
  l->rho = 1 / (in_G - l->o).norm();
  *z = {150.f, 380.f, 0, 1, 0, 0};
}

template <class S>
Vec2<double> predicted(const Segment<S>& s, const Observation& z, const Calibration<S>& theta, const Landmark<S>& l) {
  Vec2<S> r;
  TEST_ASSERT_TRUE(point_residual<S>(s, z, theta, kGravity.cast<S>(), l, &r));
  return r.template cast<double>();
}

template <class S>
void check_camera_terms(double at, double middle_line) {
  auto original = make_segment();
  Landmark<double> l;
  Observation z;
  place_landmark(original.get(), &l, &z);
  auto s = std::make_unique<Segment<S>>();
  test::cast<S>(*original, s.get());
  const Landmark<S> landmark = test::cast<S>(l);
  for (const Term& term : terms(false)) {
    const double sigma = term_prior_sigma(term), h = (std::is_same<S, float>::value ? 0.1 : 1e-3) * sigma;
    Calibration<S> theta;
    theta.camera[0] = test::cast<S>(lens(middle_line));
    theta.effects.add(term, S(at * sigma));
    ReprojectionRows<S> rows;
    const Exposure<S> exposure = exposure_of<S>(*s, z, theta, kGravity.cast<S>(), true);
    TEST_ASSERT_TRUE(point_rows<S>(z, theta, exposure, landmark, nullptr, &rows));
    const Vec2<double> column = camera_term_column<S>(term, z, theta, exposure, false, rows).template cast<double>();
    Calibration<S> up = theta, down = theta;
    up.effects.value[0] += S(h);
    down.effects.value[0] -= S(h);
    const Vec2<double> numeric = (predicted<S>(*s, z, up, landmark) - predicted<S>(*s, z, down, landmark)) / (2 * h);
    // Pixels of some hundreds in S over the step; moved by a long delay, w in the middle of it and its slope stand for
    // the motion's Taylor series: the third derivative is left out, 1e-3 of the rate at 20 ms.
    const double rounding = 300 * double(std::numeric_limits<S>::epsilon()) * 4 / h;
    const double tolerance = (std::is_same<S, float>::value ? 1e-2 : 1e-4) + (at != 0 && term.of_time() ? 1e-2 : 0);
    for (int i = 0; i < 2; ++i) {
      const Id id = Id().add("term", name_of(term)).add("at", at).add("lines", middle_line).template type<S>();
      test::check_near(id.add("row", i), "column", numeric(i), column(i), tolerance * numeric.norm() + rounding);
    }
  }
}

void test_camera_terms() {
  for (double at : {0.0, 0.7}) {
    for (double middle_line : {240.0, -320.0}) {  // rows; columns
      check_camera_terms<double>(at, middle_line);
      check_camera_terms<float>(at, middle_line);
    }
  }
}

/// Camera and terms as a solver moves them: r_CI from the left, then f and c; then the terms' values.
Calibration<double> moved_camera(Calibration<double> theta, int column, double h) {
  Vec<double, kMaxCameraColumns> delta = Vec<double, kMaxCameraColumns>::Zero();
  if (column < kMaxCameraColumns) {
    delta(column) = h;
    theta.camera[0].R_CI = so3_exp<double>(Vec3<double>(delta.head<3>())) * theta.camera[0].R_CI;
    theta.camera[0].p_CI += delta.segment<3>(3);
    theta.camera[0].intrinsics += delta.segment<4>(6);
    theta.camera[0].distortion += delta.segment<4>(10);
  } else {
    theta.effects.value[column - kMaxCameraColumns] += h;
  }
  return theta;
}

/// A camera that is warm and has a lens term beside it: all columns of the camera and of both effects by differences.
void test_warm_camera_columns() {
  const auto s = make_segment();
  Landmark<double> l;
  Observation z;
  place_landmark(s.get(), &l, &z);
  Calibration<double> theta;
  theta.camera[0] = lens();
  for (int i = 0; i < kWarmCameraTerms; ++i)  // at 4.5 degC above: 9 mrad, 1 % of f, 4 px
    theta.effects.add({TermKind::camera_warmth, static_cast<std::uint8_t>(i), 0, 0}, (i % 2 ? -1 : 1) * 2e-3);
  theta.effects.add({TermKind::radial, 0, 0, 0}, 0.01);
  theta.effects.add({TermKind::image_v, 0, 3, 1}, 0.01);
  ReprojectionRows<double> rows;
  const Exposure<double> exposure = exposure_of<double>(*s, z, theta, kGravity, true);
  TEST_ASSERT_TRUE(point_rows<double>(z, theta, exposure, l, nullptr, &rows));
  for (int column = 0; column < kMaxCameraColumns + theta.effects.n; ++column) {
    const bool of_camera = column < kMaxCameraColumns;
    const Vec2<double> analytic = of_camera ? Vec2<double>(rows.J_camera.col(column))
                                            : camera_term_column<double>(theta.effects.term[column - kMaxCameraColumns],
                                                                         z, theta, exposure, false, rows);
    const double h = 1e-6;
    const Vec2<double> numeric = (predicted<double>(*s, z, moved_camera(theta, column, h), l) -
                                  predicted<double>(*s, z, moved_camera(theta, column, -h), l)) /
                                 (2 * h);
    // pixels of 300, rounded at 1e-16, over the step; and the third derivative, next to nothing
    for (int i = 0; i < 2; ++i)
      test::check_near(Id().add("column", column).add("row", i), "derivative", numeric(i), analytic(i),
                       1e-6 * numeric.norm() + 1e-6);
  }
}

/// Image terms two ways: the moved point written again with Jets.
void test_image_terms_by_jets() {
  using T = ceres::Jet<double, 3>;
  const Vec2<double> d(-0.6, 0.45);
  const double row = 0.58;
  for (const Term& term : terms(false)) {
    if (!term.of_image()) continue;
    const T x(d.x(), 0), y(d.y(), 1), c(0.0, 2);
    const T q = x * x + y * y;
    T u = x, v = y;
    if (term.kind == TermKind::radial) u += c * x * q, v += c * y * q;
    if (term.kind == TermKind::tangential_1) u += c * 2.0 * x * y, v += c * (q + 2.0 * y * y);
    if (term.kind == TermKind::tangential_2) u += c * (q + 2.0 * x * x), v += c * 2.0 * x * y;
    if (term.kind == TermKind::image_u) u += c * x * x * y;
    if (term.kind == TermKind::image_v) v += c * y * y * y * row;
    const Vec2<double> phi = image_phi<double>(term, d, row);
    test::check_near(Id().add("term", name_of(term)), "u", u.v(2), phi.x(), 1e-12);
    test::check_near(Id().add("term", name_of(term)), "v", v.v(2), phi.y(), 1e-12);
  }
}

/// A pose moved by a long delay is where the path says: 30 ms, and 60 us per line at the image's border.
void check_exposure_on_the_path(double middle_line) {
  auto s = make_segment();
  Calibration<double> theta;
  theta.camera[0] = lens(middle_line);
  for (double t_d : {-0.03, -0.003, 0.003, 0.03}) {
    for (double line_delay : {0.0, 6e-5}) {
      theta.effects.n = 0;
      theta.effects.add(kTimeOffsetTerm, t_d);
      theta.effects.add(kLineDelayTerm, line_delay);
      const Observation z{100.f, 470.f, 0, 1, 0, 0};
      const double lines = middle_line > 0 ? 470 - 240 : 100 - 320;
      test::check_near(Id().add("lines", middle_line), "share", middle_line > 0 ? 230.0 / 240 : -220.0 / 320,
                       image_terms_at(z, theta).row, 1e-15);
      const double tau = t_d + line_delay * lines, limit = std::pow(std::fabs(tau), 3);
      const Exposure<double> at = exposure_of(*s, z, theta, kGravity, false);
      const State<double> truth = path().state(1.2 + tau);
      const Id id = Id().add("t_d", t_d).add("line_delay", line_delay);
      // tau^3 / 24 of the rate's second derivative (here up to 120 rad/s^3) and tau^3 / 12 of the jerk (up to 300
      // m/s^3), and the 16 bits of the samples: 5e-4 rad/s.
      test::check_near(id, "rotation", 0, so3_log<double>(truth.R_GI.transpose() * at.R_GI).norm(),
                       120.0 / 24 * limit + 1e-3 * std::fabs(tau));
      test::check_near(id, "position", 0, (truth.p_GI - at.p_GI).norm(), 300.0 / 12 * limit + 5e-3 * tau * tau);
    }
  }
}

void test_exposure_on_the_path() {
  check_exposure_on_the_path(240);
  check_exposure_on_the_path(-320);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_link_terms_in_double);
  RUN_TEST(test_link_terms_in_float);
  RUN_TEST(test_link_terms_away_from_zero);
  RUN_TEST(test_camera_terms);
  RUN_TEST(test_warm_camera_columns);
  RUN_TEST(test_image_terms_by_jets);
  RUN_TEST(test_exposure_on_the_path);
  return UNITY_END();
}
