// Numbers of `segcal compare` against what follows on paper, and its exit codes.
#include <unity.h>

#include <cmath>
#include <cstdio>

#include "../replay/program.h"
#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "compare/compare.h"
#include "recording.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using test::Id;
using test::write_text;

constexpr double pi = 3.14159265358979323846;
constexpr std::int64_t start_ns = 1700000000123456789;

/// A smooth path with turns about all axes; t in s.
host::Pose path_at(double t) {
  host::Pose pose;
  pose.t_ns = start_ns + std::llround(t * 1e9);
  pose.p_GI = {2 * std::sin(0.5 * t), 1.5 * std::cos(0.7 * t), 0.3 * std::sin(1.1 * t)};
  pose.q_GI = Eigen::AngleAxisd(0.4 * t, Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(0.3 * std::sin(t), Eigen::Vector3d::UnitX());
  return pose;
}

host::Poses path(double seconds, double step) {
  host::Poses out;
  for (int k = 0; k <= std::lround(seconds / step); ++k) out.push_back(path_at(k * step));
  return out;
}

host::Poses moved(host::Poses poses, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  for (host::Pose& p : poses) {
    p.p_GI = R * p.p_GI + t;
    p.q_GI = Eigen::Quaterniond(R) * p.q_GI;
  }
  return poses;
}

/// Straight ahead along x with one metre per second, 10 Hz.
host::Poses straight(double seconds) {
  host::Poses out;
  for (int k = 0; k <= 10 * seconds; ++k)
    out.push_back({start_ns + 100000000ll * k, {0.1 * k, 0, 0}, Eigen::Quaterniond::Identity()});
  return out;
}

host::TrajectoryError error_of(const host::Poses& estimate, const host::Poses& reference,
                               const host::ErrorOptions& options) {
  const auto error = host::trajectory_error(estimate, reference, options);
  TEST_ASSERT_TRUE_MESSAGE(error.has_value(), "no poses in common");
  return *error;
}

void test_alignment_takes_away_what_it_may() {
  const host::Poses truth = path(20, 0.1);
  const Eigen::Matrix3d yaw = Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d any = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(10, -20, 3);
  host::ErrorOptions options;
  struct Case {
    host::Alignment alignment;
    const Eigen::Matrix3d& R;
    bool vanishes;
  };
  for (const Case& c : {Case{host::Alignment::yaw, yaw, true}, Case{host::Alignment::se3, any, true},
                        Case{host::Alignment::se3, yaw, true}, Case{host::Alignment::yaw, any, false},
                        Case{host::Alignment::none, yaw, false}}) {
    options.alignment = c.alignment;
    const host::TrajectoryError e = error_of(moved(truth, c.R, shift), truth, options);
    const Id id = Id().add("alignment", static_cast<int>(c.alignment)).add("angle", &c.R == &yaw ? "yaw" : "any");
    // 1e-9: rounding of coordinates of some ten metres; otherwise the errors are of the size of the motion.
    if (c.vanishes) test::check_between(id, "position RMSE, m", 0, e.position_m.rmse, 1e-9);
    if (c.vanishes) test::check_between(id, "attitude RMSE, rad", 0, e.attitude_rad.rmse, 1e-7);
    if (!c.vanishes) test::check_between(id, "position RMSE, m", 0.1, e.position_m.rmse, 100);
  }
}

void test_position_statistics() {
  // Errors of 1, 2, 3, 4 cm in turn, in directions that turn too: RMSE sqrt(7.5), median 2.5, max 4 cm.
  const host::Poses truth = path(19.9, 0.1);
  host::Poses estimate = truth;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const double a = 1.3 * static_cast<double>(i);
    estimate[i].p_GI += 0.01 * static_cast<double>(1 + i % 4) * Eigen::Vector3d(std::cos(a), std::sin(a), 0);
    estimate[i].q_GI =
        estimate[i].q_GI * Eigen::Quaterniond(Eigen::AngleAxisd(i % 2 ? 0.03 : -0.01, Eigen::Vector3d::UnitY()));
  }
  host::ErrorOptions options;
  options.alignment = host::Alignment::none;
  const host::TrajectoryError e = error_of(estimate, truth, options);
  const Id id = Id().add("check", "statistics");
  TEST_ASSERT_EQUAL_UINT(200, e.poses);
  test::check_near(id, "position RMSE, m", 0.01 * std::sqrt(7.5), e.position_m.rmse, 1e-12);
  test::check_near(id, "position median, m", 0.025, e.position_m.median, 1e-12);
  test::check_near(id, "position max, m", 0.04, e.position_m.max, 1e-12);
  test::check_near(id, "attitude RMSE, rad", std::sqrt(0.5 * (9e-4 + 1e-4)), e.attitude_rad.rmse, 1e-9);
  test::check_near(id, "attitude median, rad", 0.02, e.attitude_rad.median, 1e-9);
}

void test_time_shift_is_found() {
  // The reference at 200 Hz between its samples is off by a acceleration * step^2 / 8, about 3 um: the shift by far
  // less than 10 us, at a metre per second.
  const host::Poses truth = path(30, 0.005);
  for (const double shift : {0.0234, -0.0817, 0.0}) {
    host::Poses estimate;
    for (const host::Pose& p : path(28, 0.1)) {
      estimate.push_back(path_at(1 + static_cast<double>(p.t_ns - start_ns) * 1e-9));
      estimate.back().t_ns -= std::llround(shift * 1e9);  // t_truth = t_estimate + shift
    }
    host::ErrorOptions options;
    options.largest_shift_s = 0.1;
    const host::TrajectoryError e = error_of(estimate, truth, options);
    const Id id = Id().add("shift", shift);
    test::check_near(id, "time shift, s", shift, e.time_shift_s, 1e-5);
    test::check_between(id, "position RMSE, m", 0, e.position_m.rmse, 2e-5);
  }
}

void test_relative_error_of_a_wrong_scale_and_heading() {
  const host::Poses truth = straight(30);
  host::Poses scaled = truth, turning = truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    scaled[i].p_GI *= 1.01;
    turning[i].q_GI = Eigen::Quaterniond(Eigen::AngleAxisd(0.002 * truth[i].p_GI.x(), Eigen::Vector3d::UnitZ()));
  }
  host::ErrorOptions options;
  options.segment_m = {5, 10, 100};
  const host::TrajectoryError s = error_of(scaled, truth, options), t = error_of(turning, truth, options);
  const Id id = Id().add("check", "relative");
  // Median and largest: near the end pieces are up to 10 % shorter, their errors too.
  test::check_near(id, "5 m with 1 % of scale, median, m", 0.05, s.relative[0].position_m.median, 1e-9);
  test::check_near(id, "10 m with 1 % of scale, largest, m", 0.10, s.relative[1].position_m.max, 1e-9);
  test::check_near(id, "10 m with 2 mrad/m, rad", 0.02, t.relative[1].attitude_rad.max, 1e-9);
  // The last 4.5 m have no partner within 10 % of 5 m: 301 poses less 45.
  test::check_near(id, "pairs over 5 m", 256, static_cast<double>(s.relative[0].position_m.n), 0);
  test::check_near(id, "pairs over 100 m", 0, static_cast<double>(s.relative[2].position_m.n), 0);
}

void test_gaps_are_not_bridged() {
  host::Poses truth = path(20, 0.05);
  truth.erase(truth.begin() + 100, truth.begin() + 200);  // 5 to 10 s
  host::ErrorOptions options;
  const host::TrajectoryError e = error_of(path(20, 0.1), truth, options);
  TEST_ASSERT_EQUAL_UINT(201 - 50, e.poses);  // 5.0 to 9.9 s: 9.95 s is gone too
}

void test_differences_in_sigmas() {
  const host::ParameterList a = {{"cam0.fx", "px", 256.3, 0.3, "observed"},
                                 {"gyro.sx", "-", 1.002, 0.001, "observed"},
                                 {"only.a", "", 1, 1.0, ""}};
  const host::ParameterList b = {{"gyro.sx", "-", 1.0, std::nullopt, ""}, {"cam0.fx", "px", 255.8, 0.4, "observed"}};
  const auto d = host::differences(a, b);
  const Id id = Id().add("check", "sigmas");
  TEST_ASSERT_EQUAL_UINT(2, d.size());
  test::check_near(id, "fx in sigma of a", 0.5 / 0.3, *d[0].in_a, 1e-9);
  test::check_near(id, "fx in sigma of b", 0.5 / 0.4, *d[0].in_b, 1e-9);
  test::check_near(id, "fx in sigma of the difference", 1.0, *d[0].in_difference, 1e-9);
  test::check_true(id, "a sigma that is not there", !d[1].in_b && d[1].in_a);
  test::check_near(id, "sx in sigma of the difference", 2.0, *d[1].in_difference, 1e-9);
}

void test_a_rotation_is_one_rotation() {
  // 3.1 rad about an axis is 2 pi - 3.1 about its opposite.
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -2) / 3, v = 3.1 * axis,
                        w = -(2 * pi - 3.1) * axis + Eigen::Vector3d(0.001, 0, 0);
  host::ParameterList a, b;
  const char* const name[] = {"cam0.r_CI.x", "cam0.r_CI.y", "cam0.r_CI.z"};
  for (int i = 0; i < 3; ++i) {
    a.push_back({name[i], "rad", v(i), 0.001, ""});
    b.push_back({name[i], "rad", w(i), 0.001, ""});
  }
  const auto d = host::differences(a, b);
  test::check_near(Id().add("check", "rotation"), "x, rad", -0.001, d[0].difference, 1e-9);
  test::check_near(Id().add("check", "rotation"), "z, rad", 0, d[2].difference, 1e-9);
}

/// A folder with one parameter, 100 +- 1 px off by `offset`, and a trajectory.
void write_result(const fs::path& dir, double offset, const std::string& tum) {
  char text[256];
  std::snprintf(
      text, sizeof text,
      R"({"format":1,"status":"calibrated","parameters":[{"name":"cam0.fx","value":%.3f,"sigma":1,"unit":"px"}]})",
      100 + offset);
  write_text(dir / "result.json", text);
  if (!tum.empty()) write_text(dir / "trajectory.tum", tum);
}

void test_exit_codes() {
  const test::TemporaryFolder scratch("segcal_compare");
  const fs::path root = scratch.path();
  std::string good = "# t x y z qx qy qz qw\n", late = good;
  for (int k = 0; k < 50; ++k) {
    char line[128];
    std::snprintf(line, sizeof line, "%d.5 %.3f %.3f 0 0 0 0 1\n", k, 0.1 * k, 0.01 * k * k);
    good += line;
    late += "9" + std::string(line);
  }
  write_result(root / "a", 0, good);
  write_result(root / "near", 2, good);
  write_result(root / "far", 20, good);
  write_result(root / "late", 0, late);
  write_result(root / "torn", 0, good + "60.0 1 2 3\n");
  write_text(root / "bad" / "result.json", "{\n \"format\": 1,\n oops }");
  write_text(root / "truth.json", R"({"format":1,"parameters":[{"name":"cam0.fx","value":110}]})");
  fs::create_directories(root / "empty");
  struct Case {
    std::string arguments;
    int code;
    std::string says;
  };
  const auto of = [&root](const std::string& b, const std::string& more = "") {
    return "compare \"" + (root / "a").string() + "\" \"" + (root / b).string() + "\" " + more;
  };
  for (const Case& c :
       {Case{of("near"), 0, "within tolerance"}, Case{of("near", "--sigmas 1"), 1, "above tolerance"},
        Case{of("far"), 1, "above tolerance"},
        Case{of("near", "--truth \"" + (root / "truth.json").string() + "\""), 1, "A against truth"},
        Case{of("near", "--sigma-of b --sigmas 1.9"), 1, "2 sigma, tolerance 1.9"},
        Case{of("near", "--position-rmse 0.001"), 0, "within tolerance"},
        Case{of("bad"), 2, "result.json:3: expected JSON"}, Case{of("empty"), 2, "expected result.json"},
        Case{of("nowhere"), 2, "expected a folder"}, Case{of("torn"), 2, "trajectory.tum:52: expected timestamp"},
        Case{of("late"), 2, "overlap in time"}, Case{of("near", "--align yaaw"), 2, "--align"}}) {
    const test::Outcome outcome = test::run_program(c.arguments, root);
    const Id id = Id().add("case", c.says);
    test::check_near(id, c.arguments.c_str(), c.code, outcome.code, 0);
    test::check_true(id, ("says: " + outcome.out + outcome.err).c_str(),
                     (outcome.out + outcome.err).find(c.says) != std::string::npos);
  }
  test::run_program(of("near", "--out \"" + (root / "written").string() + "\""), root);
  test::check_true(Id().add("case", "out"), "compare.json was not written",
                   fs::exists(root / "written" / "compare.json"));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_alignment_takes_away_what_it_may);
  RUN_TEST(test_position_statistics);
  RUN_TEST(test_time_shift_is_found);
  RUN_TEST(test_relative_error_of_a_wrong_scale_and_heading);
  RUN_TEST(test_gaps_are_not_bridged);
  RUN_TEST(test_differences_in_sigmas);
  RUN_TEST(test_a_rotation_is_one_rotation);
  RUN_TEST(test_exit_codes);
  return UNITY_END();
}
