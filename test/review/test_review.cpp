// What a replay says of its own result: sound data are calibrated as before, an effect that is not modelled is
// suspected or refused with its name, and a result far from its start is not believed.
#include "../replay/simulated_replay.h"
#include "../support/cases.h"
#include "clock/clock_search.h"
#include "diagnose/fault.h"
#include "review/followed.h"
#include "review/linearised.h"
#include "segcal/segcal.h"
#include "simulate/disturb.h"
#include "simulate/effect_names.h"
#include "simulate/spoil.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

host::ReplayResult reviewed(const host::SimulationResult& session, const host::Recording& recording, bool review = true,
                            const char* profile = "mobile", std::uint32_t effects = 0) {
  host::ReplayOptions options;
  options.profile = profile;
  options.core.effects = effects;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.review = review;
  return host::replay({recording}, options);
}

void test_sound_data_stay_as_they_are() {
  for (const char* scenario : {"rich", "arvr"}) {
    const Id id = Id().add("scenario", scenario);
    const host::SimulationResult session = test::simulated(scenario, 60, 3);
    const host::ReplayResult plain = reviewed(session, session.recording, false),
                             judged = reviewed(session, session.recording);
    test::check_true(id, ("status " + judged.result.status + " " + judged.cause).c_str(),
                     judged.result.status == "calibrated");
    test::check_true(id, "no suspect", judged.health.suspects.empty());
    test::check_true(id, "the same bits", plain.result_hash == judged.result_hash);
    for (std::size_t i = 0; i < plain.result.parameters.size(); ++i) {
      const host::CoreParameter &a = plain.result.parameters[i], &b = judged.result.parameters[i];
      test::check_near(id, a.name.c_str(), a.value, b.value, 0);
      test::check_near(id, (a.name + ".sigma").c_str(), a.sigma, b.sigma, 0);
    }
    test::check_between(id, "share of images used", 0.9,
                        double(judged.health.frames_used) / judged.health.frames_offered, 1);
  }
}

/// k f^2 looks like a scale to a head that stays upright. With the effect enabled the sigma says so itself.
void test_what_leaves_no_trace_is_noted() {
  const host::SimulationResult session = test::simulated("arvr", 60, 3);
  const auto answer = [&session](std::uint32_t effects, double* sigma_sz) {
    const host::ReplayResult out = reviewed(session, session.recording, true, "mobile", effects);
    for (const host::CoreParameter& p : out.result.parameters)
      if (p.name == "accel.sz") *sigma_sz = p.sigma;
    for (const host::Note& n : out.health.notes)
      if (n.name == "unseen_effects") return n.words;
    return std::string();
  };
  double without = 0, with = 0;
  const std::string noted = answer(0, &without), silent = answer(SEGCAL_EFFECT_ACCEL_NONLINEARITY, &with);
  TEST_ASSERT_TRUE_MESSAGE(noted.find("accel_nonlinearity (accel.sz by ") != std::string::npos, noted.c_str());
  TEST_ASSERT_TRUE_MESSAGE(silent.find("accel_nonlinearity") == std::string::npos, silent.c_str());
  const double moved = std::stod(noted.substr(noted.find("accel.sz by ") + 12));
  // Two printed digits, and segments that scatter in one of the two fits.
  TEST_ASSERT_DOUBLE_WITHIN(0.2 * with, with, std::hypot(without, moved));
}

/// In a kept segment: whether the answer was made from it.
bool in_use(const host::ReplayResult& out, std::int64_t t) {
  return std::any_of(out.segments.begin(), out.segments.end(),
                     [t](const host::CoreSegment& s) { return s.kept && s.start_ns <= t && t <= s.end_ns; });
}

double largest_error(const host::SimulationResult& session, const host::ReplayResult& out) {
  double largest = 0;
  for (const auto& [name, error] : test::normalised_errors(session, out.result))
    largest = std::max(largest, std::abs(error));
  return largest;
}

std::uint32_t counter(const host::ReplayResult& out, const char* name) {
  for (const auto& [key, count] : out.counters)
    if (key == name) return count;
  return 0;
}

/// One in a second, left out by the device, leaves short segments, which are right: 8.8 sigma off where they were taken
/// for motion. Beyond full scale they are no spikes.
void test_many_spikes_are_left_out_and_named() {
  const host::SimulationResult session = test::simulated("rich", 40, 7);
  for (const double value : {30.0, 300.0}) {
    const Id id = Id().add("spikes", value);
    host::Recording recording = session.recording;
    host::sim::spoil::spikes(recording, 0.005, value, 7);
    const host::ReplayResult out = reviewed(session, recording);
    const bool inside = value < 157;
    test::check_true(id, ("status " + out.result.status + " " + out.cause).c_str(), out.result.status == "calibrated");
    test::check_true(id, "named",
                     (!out.health.suspects.empty() && out.health.suspects.front().name == "spikes.imu") == inside);
    test::check_near(id, "spikes that the device sees", inside ? host::spikes_of(recording).size() : 0,
                     counter(out, "imu_spikes"), inside ? 2 : 0);
    test::check_between(id, "largest error/sigma", 0, largest_error(session, out),
                        5);  // of 26 entries; 2.9 is the largest of ten such recordings
  }
}

/// One alone, taken for motion, moved gyro.mx by 7.8 sigma: the
/// segment that it falls into ends before it, and the rest calibrates.
void test_of_a_spike_nothing_is_used() {
  const host::SimulationResult session = test::simulated("rich", 40, 7);
  const std::size_t first = 600, step = 900;
  for (std::size_t at = first; at + 100 < session.recording.imu.samples.size(); at += step) {
    const Id id = Id().add("spike", at);
    host::Recording recording = session.recording;
    recording.imu.samples[at].gyro[1] += 5;
    const host::ReplayResult out = reviewed(session, recording);
    test::check_near(id, "spikes that the device sees", 1, counter(out, "imu_spikes"), 0);
    test::check_true(id, "none in a kept segment", !in_use(out, recording.imu.samples[at].t_ns));
    test::check_true(id, "named", !out.health.suspects.empty() && out.health.suspects.front().name == "spikes.imu");
    test::check_true(id, ("status " + out.result.status + " " + out.cause).c_str(), out.result.status == "calibrated");
    test::check_between(id, "largest error/sigma", 0, largest_error(session, out),
                        5);  // of 26 entries; 3.2 without spikes, 7.8 with one that is used
  }
}

/// 2 ms move values by two sigmas: suspected by name. With 8 ms the odometry of a shaken device does not stay: refused,
/// the start stays, and the cause names the clocks.
void test_an_offset_that_is_not_modelled_is_named() {
  const host::SimulationResult session = test::simulated("rich", 60, 3);
  for (const double offset : {0.002, 0.008}) {
    const Id id = Id().add("offset", offset);
    host::Recording recording = session.recording;
    host::shift_frames(-offset, &recording);
    const host::ReplayResult out = reviewed(session, recording);
    bool named = false;
    for (const host::Suspect& s : out.health.suspects) named |= s.name == "time_offset";
    if (offset < 0.004) {
      test::check_true(id, "time_offset is suspected", named);
      continue;
    }
    test::check_true(id, ("refused: " + out.result.status).c_str(), out.result.status != "calibrated");
    test::check_true(id, ("cause: " + out.cause).c_str(),
                     out.cause.find("image rotation and gyroscope are shifted by") != std::string::npos);
    test::check_near(id, "fx as it was", session.nominal.cameras[0].intrinsics(0),
                     out.calibration.cameras[0].intrinsics(0), 0);
  }
}

/// Images and gyroscope agree; the accelerometer's axes have the other sign, as some systems state them. The cause says
/// where to look, and not that the motion was too little.
void test_an_inverted_accelerometer_is_looked_for() {
  const host::SimulationResult session = test::simulated("arvr", 30, 3);
  host::Recording recording = session.recording;
  for (host::ImuSample& s : recording.imu.samples)
    for (double& a : s.accel) a = -a;
  const host::ReplayResult out = reviewed(session, recording);
  test::check_true(Id(), out.result.status.c_str(), out.result.status != "calibrated");
  test::check_true(Id(), ("cause: " + out.cause).c_str(), out.cause.find("accelerometer") != std::string::npos);
}

/// The image swings by 6 px every eight seconds, as with optical stabilisation: segments contradict each other, and
/// more motion would not help. (The core itself tells too few parameters.)
void test_segments_that_contradict_each_other_are_the_cause() {
  const host::SimulationResult session = test::simulated("arvr", 60, 3);
  host::Recording recording = session.recording;
  std::vector<host::Frame>& frames = recording.cameras[0].frames;
  for (host::Frame& f : frames) {
    const double t = 1e-9 * static_cast<double>(f.t_ns - frames.front().t_ns);
    for (host::TrackPoint& p : f.points) p.u += 6 * std::sin(2 * M_PI * t / 8);
  }
  const host::ReplayResult out = reviewed(session, recording);
  test::check_true(Id(), out.result.status.c_str(), out.result.status != "calibrated");
  test::check_true(Id(), ("cause: " + out.cause).c_str(),
                   out.cause.rfind("the segments disagree with each other", 0) == 0);
}

/// Tracks that end once are said, and are not the cause: the clocks are.
void test_a_remark_is_no_cause() {
  const host::SimulationResult session = test::simulated("rich", 60, 3);
  host::Recording recording = session.recording;
  host::shift_frames(-0.008, &recording);
  host::sim::spoil::renumber_from_middle(recording);
  const host::ReplayResult out = reviewed(session, recording);
  test::check_true(Id(), ("cause: " + out.cause).c_str(),
                   out.cause.find("image rotation and gyroscope are shifted by") != std::string::npos);
  test::check_true(Id(), "said", !out.health.suspects.empty() && out.health.suspects.back().name == "lost_tracks.cam0");
}

/// By 2 deg. Usually the filter begins anew, and two newer segments contradict the older ones, which go. One of 17
/// devices goes on with the camera of before, and takes the turn for a step of the bias: refused, if for that. Where a
/// single segment is kept since the turn, nothing says which is right.
void test_a_camera_that_turned_is_named() {
  struct Case {
    std::uint64_t seed;
    const char *at_s, *said;
  };
  for (const Case& c : {Case{1, "20", ""},
                        {3, "20", ""},
                        {8, "20", "the gyroscope's bias steps"},
                        {1, "30", ""},
                        {2, "30", "cam0.r_CI rotates by"},
                        {5, "30", "cam0.r_CI rotates by"}}) {
    const Id id = Id().add("seed", c.seed).add("at", c.at_s);
    if (!test::selected(id.text())) continue;
    host::SimulationOptions options;
    options.seconds = 40;
    options.seed = c.seed;
    options.effects.push_back(
        host::sim::parse_effect(std::string("calibration_shift=cam0.r_CI,") + c.at_s + ",0.03,-0.02,0"));
    const host::SimulationResult session = host::simulate(options);
    const host::ReplayResult out = reviewed(session, session.recording);
    const std::string said = c.said;
    test::check_true(id, ("status " + out.result.status + ", cause: " + out.cause).c_str(),
                     (out.result.status == "calibrated") == said.empty());
    test::check_true(id, ("cause: " + out.cause).c_str(), out.cause.find(said) != std::string::npos);
    test::check_true(id, "outdated segments", !said.empty() || counter(out, "segments_outdated") > 0);
  }
}

/// Of the last session's newer half, three at least: a filter that went on with a camera that is another one.
void test_segments_that_do_not_follow_are_counted() {
  std::vector<host::CoreSegment> all(14);
  for (std::size_t i = 4; i < all.size(); ++i) all[i].session = 1;  // ten, of which the newer half is five
  TEST_ASSERT_TRUE(host::review::segments_followed(all));
  for (const std::size_t i : {0, 1, 2, 3, 4, 5, 6, 7, 8}) all[i].settled = false;
  TEST_ASSERT_TRUE(host::review::segments_followed(all));
  all[9].settled = all[11].settled = false;
  TEST_ASSERT_TRUE(host::review::segments_followed(all));
  all[13].settled = false;
  TEST_ASSERT_FALSE(host::review::segments_followed(all));
  const std::string words = host::review::followed_words(all);
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, static_cast<int>(words.find("3 of the last 5 segments do not follow")),
                                words.c_str());
}

/// What a driver that trims its sensor anew leaves behind: chi2/dof 1.03 to 2.4, calibrated without the rule, with
/// entries 4 to 10 sigma off. The size that is told is within a tenth: 2 to 5 % are its sigma, and where the step's
/// instant falls between keyframes takes as much.
void test_a_bias_that_steps_is_refused_and_named() {
  struct Case {
    const char *scenario, *sensor;
    double size;
    int axis;
    const char* profile;
    std::uint32_t effects;
  };
  for (const Case& c : {Case{"rich", "gyro", 0.01, 0, "mobile", 0},
                        {"rich", "accel", 0.3, 1, "mobile", 0},
                        {"arvr", "accel", 0.1, 2, "mobile", 0},
                        {"rich", "gyro", 0.02, 1, "mcu", 0},
                        {"rich", "accel", 0.1, 0, "mobile", SEGCAL_EFFECT_ROLLING_SHUTTER}}) {
    const Id id = Id().add("scenario", c.scenario)
                      .add("sensor", c.sensor)
                      .add("size", c.size)
                      .add("profile", c.profile)
                      .add("effects", c.effects);
    if (!test::selected(id.text())) continue;
    const host::SimulationResult session = test::simulated(c.scenario, 60, 5);
    host::Recording recording = session.recording;
    const bool gyro = std::string(c.sensor) == "gyro";
    host::disturb::offset(recording, gyro ? host::disturb::Sensor::gyro : host::disturb::Sensor::accel,
                          c.size * Eigen::Vector3d::Unit(c.axis), host::disturb::middle_ns(recording));
    const host::ReplayResult out = reviewed(session, recording, true, c.profile, c.effects);
    test::check_true(id, ("refused: " + out.result.status).c_str(), out.result.status != "calibrated");
    test::check_true(
        id, "named",
        !out.health.suspects.empty() && out.health.suspects.front().name == std::string("bias_step.") + c.sensor);
    const std::string before = std::string("the ") + (gyro ? "gyroscope" : "accelerometer") + "'s bias steps by ";
    test::check_true(id, ("cause: " + out.cause).c_str(), out.cause.rfind(before, 0) == 0);
    test::check_true(id, ("axis: " + out.cause).c_str(),
                     out.cause.find(std::string("(") + "xyz"[c.axis] + ")") != std::string::npos);
    test::check_near(id, "size", c.size, std::atof(out.cause.c_str() + std::min(before.size(), out.cause.size())),
                     0.1 * c.size);
  }
}

/// An effect that explains more, and moves no entry by three
/// sigmas, hides none of this: the answer was called calibrated.
void test_a_step_beside_a_larger_effect_is_refused() {
  host::SimulationOptions options;
  options.seconds = 60;
  options.seed = 41;
  options.effects.push_back(host::sim::parse_effect("gyro_g_sensitivity=3e-4,0,0,0,3e-4,0,0,0,3e-4"));
  const host::SimulationResult session = host::simulate(options);
  host::Recording recording = session.recording;
  host::disturb::offset(recording, host::disturb::Sensor::accel, {0, 0.1, 0},
                        recording.imu.samples.front().t_ns + 33000000000);
  const host::ReplayResult out = reviewed(session, recording);
  test::check_true(Id(), ("refused: " + out.result.status).c_str(), out.result.status != "calibrated");
  test::check_true(Id(), ("cause: " + out.cause).c_str(),
                   out.cause.rfind("the accelerometer's bias steps by ", 0) == 0);
  test::check_true(Id(), "the effect is named first",
                   !out.health.suspects.empty() && out.health.suspects.front().name == "gyro_g_sensitivity");
}

/// Where tracks drift, and are weighed by that.
void test_a_step_is_found_in_tracks_that_drift() {
  host::SimulationOptions options;
  options.seconds = 60;
  options.seed = 5;
  options.tracks.pixel_noise_px = 0.1;
  options.tracks.walk_px_per_sqrt_s = 0.9;
  const host::SimulationResult session = host::simulate(options);
  host::Recording recording = session.recording;
  host::disturb::offset(recording, host::disturb::Sensor::gyro, {0, 0.01, 0}, host::disturb::middle_ns(recording));
  host::ReplayOptions replay;
  replay.core.calibration = session.nominal;
  replay.core.noise = recording.imu.noise;
  replay.core.pixel_sigma = options.tracks.pixel_noise_px;
  replay.core.track_walk = options.tracks.walk_px_per_sqrt_s;
  replay.review = true;
  const host::ReplayResult out = host::replay({recording}, replay);
  test::check_true(Id(), ("cause: " + out.cause).c_str(), out.cause.rfind("the gyroscope's bias steps by ", 0) == 0);
}

/// 1 ms that nobody states moves values by about two sigmas: said, and held by the sigmas.
void test_what_is_suspected_is_in_the_sigmas() {
  host::SimulationOptions options;
  options.seconds = 60;
  options.seed = 20;
  options.effects.push_back(host::sim::parse_effect("time_offset=0.001"));
  const host::SimulationResult session = host::simulate(options);
  const host::ReplayResult out = reviewed(session, session.recording);
  test::check_true(Id(), ("status " + out.result.status + " " + out.cause).c_str(), out.result.status == "calibrated");
  TEST_ASSERT_FALSE(out.health.suspects.empty());
  const host::Suspect& s = out.health.suspects.front();
  TEST_ASSERT_EQUAL_STRING("time_offset", s.name.c_str());
  TEST_ASSERT_TRUE(s.in_sigmas);
  for (std::size_t i = 0; i < out.result.parameters.size(); ++i) {
    const double least = std::hypot(out.health.noise_sigmas.at(i), s.moved.at(i));
    TEST_ASSERT_TRUE(out.result.parameters[i].sigma > 0.999 * std::min(least, out.result.parameters[i].prior_sigma));
  }
}

/// The prior allows 4 % in f: a start that is 40 % off is no start of this device.
void test_a_step_that_the_prior_forbids_is_refused() {
  host::SimulationResult session = test::simulated("rich", 60, 3);
  session.nominal.cameras[0].intrinsics.head<2>() *= 1.5;  // 8.3 of the start's sigmas: 4 % of f
  const host::ReplayResult out = reviewed(session, session.recording);
  test::check_true(Id(), ("status " + out.result.status).c_str(), out.result.status != "calibrated");
  test::check_true(Id(), out.cause.c_str(), out.cause.rfind("the result is too far from the start", 0) == 0);
}

/// Two segments of a second tell too little; the words say how to keep more, and that helps.
void test_advice_to_keep_more_segments_is_good() {
  const host::SimulationResult session = test::simulated("nav", 40, 3), brief = test::simulated("rich", 4, 3);
  const auto kept = [](const host::SimulationResult& session, const char* profile, int segments) {
    host::ReplayOptions options;
    options.profile = profile;
    options.core.calibration = session.nominal;
    options.core.noise = session.recording.imu.noise;
    options.core.segment_s = 1;
    options.core.segments = segments;
    options.review = true;
    return host::replay({session.recording}, options);
  };
  const host::ReplayResult few = kept(session, "mobile", 2);
  const std::size_t at = few.cause.find("--profile host --segments ");
  TEST_ASSERT_TRUE_MESSAGE(at != std::string::npos, few.cause.c_str());
  const host::ReplayResult more = kept(session, "host", std::stoi(few.cause.substr(at + 26)));
  TEST_ASSERT_EQUAL_STRING_MESSAGE("calibrated", more.result.status.c_str(), more.cause.c_str());
  TEST_ASSERT_TRUE(largest_error(session, more) < 5);
  // One of three tells enough to be kept: a database of two has room left.
  const std::string nothing_lost = kept(brief, "mobile", 2).cause;
  TEST_ASSERT_TRUE_MESSAGE(nothing_lost.find("half are needed") != std::string::npos, nothing_lost.c_str());
  TEST_ASSERT_TRUE_MESSAGE(nothing_lost.find("--profile") == std::string::npos, nothing_lost.c_str());
}

/// Near a half turn the two rotation vectors are opposite; the step between the rotations is small all the same.
void test_steps_of_rotations_are_small_rotations() {
  std::vector<host::CoreParameter> p(3);
  const char* const names[] = {"cam0.r_CI.x", "cam0.r_CI.y", "cam0.r_CI.z"};
  const double before[] = {3.13, 0, 0}, after[] = {-3.14, 0, 0.01};
  for (std::size_t i = 0; i < 3; ++i) {
    p[i].name = names[i];
    p[i].initial = before[i];
    p[i].value = after[i];
  }
  test::check_between(Id(), "step", 0.01, host::review::step_from_start(p).norm(),
                      0.04);  // 2 pi - 6.27 and 0.02 of tilt
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_steps_of_rotations_are_small_rotations);
  RUN_TEST(test_sound_data_stay_as_they_are);
  RUN_TEST(test_what_leaves_no_trace_is_noted);
  RUN_TEST(test_many_spikes_are_left_out_and_named);
  RUN_TEST(test_of_a_spike_nothing_is_used);
  RUN_TEST(test_an_offset_that_is_not_modelled_is_named);
  RUN_TEST(test_an_inverted_accelerometer_is_looked_for);
  RUN_TEST(test_segments_that_contradict_each_other_are_the_cause);
  RUN_TEST(test_a_remark_is_no_cause);
  RUN_TEST(test_a_camera_that_turned_is_named);
  RUN_TEST(test_segments_that_do_not_follow_are_counted);
  RUN_TEST(test_a_bias_that_steps_is_refused_and_named);
  RUN_TEST(test_a_step_beside_a_larger_effect_is_refused);
  RUN_TEST(test_a_step_is_found_in_tracks_that_drift);
  RUN_TEST(test_what_is_suspected_is_in_the_sigmas);
  RUN_TEST(test_a_step_that_the_prior_forbids_is_refused);
  RUN_TEST(test_advice_to_keep_more_segments_is_good);
  return UNITY_END();
}
