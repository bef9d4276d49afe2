// Faults of the data: each is found with its kind and sensor, and a sound recording has none.
#include <cmath>
#include <string>
#include <vector>

#include "../support/cases.h"
#include "diagnose/clock.h"
#include "diagnose/fault.h"
#include "simulate/disturb.h"
#include "simulate/effect_names.h"
#include "simulate/fault_kinds.h"
#include "simulate/simulate.h"
#include "unity.h"

namespace {

host::SimulationResult simulated(const std::string& scenario, std::uint64_t seed,
                                 const std::vector<std::string>& effects = {}, double seconds = 60) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = seconds;
  options.seed = seed;
  for (const std::string& text : effects) options.effects.push_back(host::sim::parse_effect(text));
  return host::simulate(options);
}

std::string listed(const std::vector<host::Fault>& faults) {
  std::string text;
  for (const host::Fault& f : faults) text += f.kind + "/" + f.sensor + ": " + f.words + " ";
  return text.empty() ? "none" : text;
}

void check_none(const test::Id& id, const host::Recording& recording, const host::Calibration& start) {
  const auto faults = host::find_faults(recording, start);
  if (!faults.empty() && test::selected(id.text())) test::fail_case(id, "a false alarm: " + listed(faults));
}

/// Exactly one fault, or several of the same kind on different axes.
const host::Fault only(const test::Id& id, const std::vector<host::Fault>& faults, const std::string& kind,
                       const std::string& sensor) {
  if (faults.empty()) test::fail_case(id, "nothing was found");
  for (const host::Fault& f : faults)
    if (f.kind != kind || f.sensor.rfind(sensor, 0) != 0)
      test::fail_case(id, "found something else: " + listed(faults));
  test::check_true(id, "says what to do", faults[0].words.find('.') != std::string::npos && faults[0].count > 0);
  test::check_true(id, "says where", faults[0].first_ns > 0 && faults[0].last_ns >= faults[0].first_ns);
  return faults[0];
}

void sound_recordings_have_no_fault() {
  const auto id = test::Id();
  for (const char* scenario : {"rich", "arvr", "nav", "still", "rotation", "line", "planar"})
    for (std::uint64_t seed : {21, 22, 23}) {
      const auto here = id.add("scenario", scenario).add("seed", seed);
      if (!test::selected(here.text())) continue;
      const auto session = simulated(scenario, seed);
      check_none(here, session.recording, session.nominal);
    }
}

/// An effect of the catalogue, or one that it does not hold, is no fault of the data.
void effects_are_no_faults() {
  for (const auto& entry : host::sim::effect_entries()) {
    const std::string name = entry.name;
    const bool fault = entry.kind == host::sim::EffectKind::fault || name == "saturation" ||
                       name == "dropped_samples" || name == "stamp_jitter";
    const auto id = test::Id().add("effect", name);
    if (fault || !test::selected(id.text())) continue;
    const auto session = simulated("rich", 31, {name + "=" + entry.example});
    check_none(id, session.recording, session.nominal);
  }
}

struct Case {
  const char *scenario, *fault, *kind, *sensor;
};

void each_fault_is_found_alone() {
  const Case cases[] = {
      {"rich", "saturation=4,0", "saturation", "gyro"},  // a tenth of a percent of the samples of one axis
      {"rich", "saturation=0,16", "saturation", "accel"},
      {"arvr", "saturation=1,0", "saturation", "gyro"},
      {"rich", "dropped_samples=50", "dropped_samples", "imu"},
      {"still", "dropped_samples=300", "dropped_samples", "imu"},
      {"rich", "stamp_jitter=0.0003", "stamp_jitter", "imu"},
      {"rich", "stamp_jitter=0.001", "stamp_jitter", "imu"},
      {"rich", "stamp_jitter=0,0.001", "stamp_jitter", "cam0"},
      {"rich", "frozen=gyro,20,0.2", "frozen", "gyro"},
      {"still", "frozen=accel,20,2", "frozen", "accel"},
      {"rich", "unit=gyro", "unit", "gyro"},
      {"still", "unit=gyro", "unit", "gyro"},
      {"arvr", "unit=gyro", "unit", "gyro"},
      {"rich", "unit=accel", "unit", "accel"},
      {"still", "unit=accel", "unit", "accel"},
      {"rich", "axes=gyro,yxz", "axes", "gyro"},
      {"arvr", "axes=gyro,x-yz", "axes", "gyro"},
      {"nav", "axes=gyro,-x-yz", "axes", "gyro"},
      {"nav", "axes=gyro,zxy", "axes", "gyro"},
      {"rich", "axes=accel,yxz", "axes", "accel"},
      {"rich", "axes=accel,x-yz", "axes", "accel"},
      {"arvr", "axes=accel,zxy", "axes", "accel"},
      {"rich", "clock_drift=0,0.3", "clock_offset", "cam0"},
      {"nav", "clock_drift=0,-0.5", "clock_offset", "cam0"},
      {"rich", "clock_drift=1e-4", "clock_drift", "cam0"},
      {"arvr", "clock_drift=-1e-3", "clock_drift", "cam0"},
  };
  for (const Case& c : cases) {
    const auto id = test::Id().add("scenario", c.scenario).add("fault", c.fault);
    if (!test::selected(id.text())) continue;
    const auto session = simulated(c.scenario, 41, {c.fault});
    only(id, host::find_faults(session.recording, session.nominal), c.kind, c.sensor);
  }
}

/// Offsets of windows of 10 s, sigma 1 ms, on a slope, with a scatter of so many of these sigmas about it.
host::ClockDrift drift_of(int windows, double slope, double scatter) {
  std::vector<host::OffsetInWindow> out;
  for (int i = 0; i < windows; ++i) {
    const double sign = i % 4 == 0 || i % 4 == 3 ? 1 : -1;  // + - - +: no slope of its own over four
    out.push_back({10.0 * i, slope * 10 * i + sign * scatter * 1e-3, 1e-3});
  }
  return host::drift_of(out);
}

/// Over a minute of real motion the six offsets rise by chance (EuRoC's V1_02: 49 us/s, seven of the line's own
/// sigmas); more than that, or the same for minutes, is a drift. Level: 1e-4 of sound recordings.
void a_few_windows_make_no_drift() {
  // sigma of a slope over six windows of 1 ms is 24 us/s
  TEST_ASSERT_TRUE(drift_of(6, 6.5 * 24e-6, 0.9).log10_p > -4);
  TEST_ASSERT_TRUE(drift_of(6, 17 * 24e-6, 0.7).log10_p < -4);
  // over five minutes 2.1 us/s; windows that scatter by three sigmas make 6.3 of it
  TEST_ASSERT_TRUE(drift_of(30, 6.5 * 2.1e-6, 3).log10_p > -4);
  TEST_ASSERT_TRUE(drift_of(30, 6.5 * 6.3e-6, 3).log10_p < -4);
  TEST_ASSERT_EQUAL_DOUBLE(0, drift_of(2, 1e-3, 0).log10_p);
}

void counts_and_places_are_right() {
  auto session = simulated("rich", 51);
  const auto clean = session.recording;
  host::disturb::drop_imu_samples(session.recording, 50);
  const auto id = test::Id().add("check", "dropped");
  const auto dropped = only(id, host::find_faults(session.recording, session.nominal), "dropped_samples", "imu");
  TEST_ASSERT_EQUAL_size_t(clean.imu.samples.size() / 50, dropped.count);
  TEST_ASSERT_EQUAL_INT64(clean.imu.samples[48].t_ns, dropped.first_ns);  // the sample before the first hole

  session.recording = clean;
  host::disturb::freeze(session.recording, host::disturb::Sensor::gyro, clean.imu.samples[2000].t_ns, 1);
  const auto frozen = only(id, host::find_faults(session.recording, session.nominal), "frozen", "gyro");
  TEST_ASSERT_EQUAL_INT64(clean.imu.samples[2000].t_ns, frozen.first_ns);
  TEST_ASSERT_INT64_WITHIN(1, 200, static_cast<std::int64_t>(frozen.count));

  session.recording = clean;
  host::disturb::clip(session.recording, 0, 15);
  std::size_t clipped[3] = {0, 0, 0};
  for (const auto& s : clean.imu.samples)
    for (std::size_t i = 0; i < 3; ++i) clipped[i] += std::abs(s.accel[i]) >= 15 ? 1 : 0;
  for (const auto& f : host::find_faults(session.recording, session.nominal))
    TEST_ASSERT_EQUAL_size_t(clipped[f.sensor.back() - 'x'], f.count);
}

/// Spikes, not a range that ends there, even where many have one height.
void spikes_are_found() {
  for (const char* kind : {"spikes_inside_range", "bits_flipped"})
    for (const char* scenario : {"rich", "arvr", "still"}) {
      const auto id = test::Id().add("fault", kind).add("scenario", scenario);
      if (!test::selected(id.text())) continue;
      auto session = simulated(scenario, 43);
      host::sim::fault_kind(kind).spoil(session.recording, 43);
      only(id, host::find_faults(session.recording, session.nominal), "spikes", "imu");
    }
}

void other_faults_of_the_log_are_found() {
  const auto clean = simulated("rich", 61, {}, 30);
  const auto id = test::Id().add("check", "log");
  auto recording = clean.recording;
  for (auto& frame : recording.cameras[0].frames) frame.t_ns += 3600000000000;
  only(id.add("case", "overlap"), host::find_faults(recording, clean.nominal), "no_overlap", "cam0");
  recording = clean.recording;
  recording.imu.noise.rate_hz = 100;
  const auto rate = only(id.add("case", "rate"), host::find_faults(recording, clean.nominal), "rate", "imu");
  TEST_ASSERT_TRUE_MESSAGE(rate.words.find("State the rate") != std::string::npos, rate.words.c_str());
  recording.imu.noise.rate_hz = 0.2;  // a thousandth: as if stamps in us were taken for ns
  for (const auto& f : host::find_faults(recording, clean.nominal)) {
    if (f.kind == "rate")
      TEST_ASSERT_TRUE_MESSAGE(f.words.find("Stamps are in ns") != std::string::npos, f.words.c_str());
  }
  recording = clean.recording;
  for (std::size_t k = 0; k + 1 < recording.imu.samples.size(); k += 50)
    std::swap(recording.imu.samples[k].t_ns, recording.imu.samples[k + 1].t_ns);
  bool back = false;
  for (const auto& f : host::find_faults(recording, clean.nominal)) back = back || f.kind == "stamps_back";
  TEST_ASSERT_TRUE(back);
  recording = clean.recording;
  for (std::size_t k = 100; k < 200; ++k) recording.imu.samples[k].gyro[1] = std::nan("");
  only(id.add("case", "nan"), host::find_faults(recording, clean.nominal), "not_finite", "gyro");
  recording = clean.recording;
  host::disturb::scale(recording, host::disturb::Sensor::accel, Eigen::Vector3d::Constant(0.5));
  only(id.add("case", "half"), host::find_faults(recording, clean.nominal), "gravity_norm", "accel");
  recording = clean.recording;
  for (std::size_t k = 1000; k < 1500; ++k)
    recording.imu.samples[k].gyro[2] = recording.imu.samples[1000].gyro[2];  // one channel of three
  const auto dead = only(id.add("case", "channel"), host::find_faults(recording, clean.nominal), "frozen", "gyro.z");
  TEST_ASSERT_EQUAL_size_t(500, dead.count);
}

/// Images of half the calibrated size, and of twice.
void other_image_sizes_are_found() {
  const auto clean = simulated("rich", 62, {}, 30);
  for (const double factor : {0.5, 2.0}) {
    auto recording = clean.recording;
    for (auto& frame : recording.cameras[0].frames)
      for (auto& p : frame.points) p.u *= factor, p.v *= factor;
    bool found = false;
    for (const auto& f : host::find_faults(recording, clean.nominal))
      found = found || (f.kind == "image_size" && f.sensor == "cam0");
    TEST_ASSERT_TRUE_MESSAGE(found, factor < 1 ? "half" : "twice");
  }
}

/// Whatever is missing or too short is passed over, not crashed on.
void little_data_is_no_trouble() {
  TEST_ASSERT_TRUE(host::find_faults({}, {}).empty());
  const auto session = simulated("rich", 71, {}, 1);
  check_none(test::Id().add("seconds", 1), session.recording, session.nominal);
  auto recording = session.recording;
  recording.cameras.clear();
  check_none(test::Id().add("cameras", 0), recording, session.nominal);
}

struct Unit {
  const char* scenario;
  host::disturb::Sensor sensor;
  double factor;      ///< readings over those in rad/s or m/s^2
  const char* words;  ///< what the first sentence says
};

/// Whatever the log is in, the sentence says what to multiply by.
void units_are_named() {
  constexpr double g = 9.80665, degrees = 57.29578;
  constexpr auto accel = host::disturb::Sensor::accel, gyro = host::disturb::Sensor::gyro;
  const Unit units[] = {
      {"rich", accel, 1 / g, "which is g."},        {"still", accel, 1000 / g, "which is mg "},
      {"rich", accel, 1000 / g, "which is mg "},    {"rich", accel, 2048 / g, "raw counts"},
      {"still", accel, 16384 / g, "raw counts"},    {"rich", gyro, degrees, "deg/s. Multiply by pi / 180:"},
      {"rich", gyro, 1000 * degrees, "mdeg/s"},     {"rich", gyro, 16.4 * degrees, "raw counts"},
      {"still", gyro, 131 * degrees, "raw counts"},
  };
  for (const Unit& unit : units) {
    const auto id = test::Id().add("scenario", unit.scenario).add("words", unit.words).add("factor", unit.factor);
    if (!test::selected(id.text())) continue;
    auto session = simulated(unit.scenario, 41);
    host::disturb::scale(session.recording, unit.sensor, Eigen::Vector3d::Constant(unit.factor));
    const std::vector<host::Fault> faults = host::find_faults(session.recording, session.nominal);
    test::check_true(id, "no fault", !faults.empty());
    test::check_true(id, (faults.front().kind + ": " + faults.front().words).c_str(),
                     faults.front().kind == "unit" && faults.front().words.find(unit.words) != std::string::npos);
  }
}

}  // namespace

void setUp() {}
void tearDown() {}

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(sound_recordings_have_no_fault);
  RUN_TEST(effects_are_no_faults);
  RUN_TEST(each_fault_is_found_alone);
  RUN_TEST(units_are_named);
  RUN_TEST(a_few_windows_make_no_drift);
  RUN_TEST(counts_and_places_are_right);
  RUN_TEST(spikes_are_found);
  RUN_TEST(other_faults_of_the_log_are_found);
  RUN_TEST(other_image_sizes_are_found);
  RUN_TEST(little_data_is_no_trouble);
  return UNITY_END();
}
