// A device with an effect, calibrated with that effect enabled: is its value found, and is the rest of theta as good as
// without it? The simulator's effects are written apart from the core.
#include <unity.h>

#include "../support/cases.h"
#include "file_output.h"
#include "replay/model_file.h"
#include "simulate/effect_names.h"
#include "simulated_replay.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

struct Case {
  const char* name;
  const char* spec;  ///< as `segcal simulate --effect` takes it
  bool reads_columns = false;
};

const Case kCases[] = {
    {"time_offset", "time_offset=0.004"},
    {"time_offset", "time_offset=-0.003"},
    {"rolling_shutter", "rolling_shutter=3e-5"},
    {"rolling_shutter", "rolling_shutter=-2e-5", true},
    {"radial_residual", "radial_residual=3e-3"},
    {"tangential_residual", "tangential_residual=1e-3,-2e-3"},
    {"gyro_g_sensitivity", "gyro_g_sensitivity=4e-4,-2e-4,3e-4,1e-4,-5e-4,2e-4,3e-4,-1e-4,4e-4"},
    {"gyro_nonlinearity", "gyro_nonlinearity=2e-3,-1e-3,3e-3"},
    {"accel_nonlinearity", "accel_nonlinearity=3e-4,-2e-4,4e-4"},
    {"gyro_temperature", "gyro_temperature=3e-4,-2e-4,2e-4"},
    {"accel_temperature", "accel_temperature=5e-3,-3e-3,4e-3"},
    {"gyro_lag", "gyro_lag=0.004"},
    {"accel_axis_offset", "accel_axis_offset=0.01,-0.02,0.015,0.02,0.01,-0.01"},
    {"camera_temperature", "camera_temperature=2e-4,-3e-4,2e-4,3e-4,-2e-4,3e-4"},
};

host::ReplayResult replayed_with(const host::SimulationResult& session, const std::string& effect) {
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.core.has_temperature = session.recording.imu.has_temperature;
  host::EffectChoice choice;
  if (!effect.empty()) choice.enable(effect);
  choice.apply(&options.core);
  return host::replay({session.recording}, options);
}

host::SimulationResult session_with(const std::string& spec, std::uint64_t seed, bool reads_columns) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = 60;
  options.seed = seed;
  options.effects = {host::sim::parse_effect(spec)};
  options.reads_columns = reads_columns;
  return host::simulate(options);
}

void check_case(const Case& c, std::uint64_t seed) {
  const Id id = Id().add("effect", c.spec).add("seed", seed);
  if (!test::selected(id.text())) return;
  const host::SimulationResult session = session_with(c.spec, seed, c.reads_columns);
  const host::ReplayResult with = replayed_with(session, c.name);
  std::map<std::string, host::CoreParameter> found;
  for (const host::CoreParameter& p : with.result.parameters) found[p.name] = p;
  test::check_between(id, "calibrated", 1, with.result.status == "calibrated" ? 1 : 0, 1);
  for (const auto& p : host::sim::parse_effect(c.spec)->truth().parameters) {
    const std::string name = std::string(c.name) + "." + p.name;
    TEST_ASSERT_EQUAL_INT_MESSAGE(1, static_cast<int>(found.count(name)), name.c_str());
    TEST_ASSERT_EQUAL_STRING(p.unit.c_str(), found[name].unit.c_str());
    // Some forty parameters: beyond 4.5 sigma is once in 3000 such runs.
    test::check_between(id.add("parameter", name), "error / sigma", -4.5,
                        (found[name].value - p.value) / found[name].sigma, 4.5);
    std::printf("%s %s: %.5g +- %.2g, true %.5g, %s\n", id.text().c_str(), name.c_str(), found[name].value,
                found[name].sigma, p.value, found[name].verdict.c_str());
  }
  // chi2/dof of the simulator's noise is 1 within 0.03 at some thousand degrees of freedom (test_rich.cpp).
  test::check_between(id, "chi2/dof", 0.9, with.result.chi2 / with.result.dof, 1.1);
}

void test_enabled_effects_are_found() {
  for (const Case& c : kCases) check_case(c, 1);
}

/// What a replay writes, the next one reads: the same effects, and starts at the values.
void test_model_file() {
  host::ReplayResult result;
  result.result.parameters = {};
  const host::Calibration calibration = host::simulate([] {
                                          host::SimulationOptions o;
                                          o.seconds = 1;
                                          return o;
                                        }())
                                            .nominal;
  result.calibration = calibration;
  for (const char* name : {"time_offset.t_d", "gyro_lag.tau", "gyro_x:fy*wz", "image_u:x^2*y"}) {
    host::CoreParameter p;
    p.name = name;
    p.unit = "s";
    p.verdict = "observed";
    p.value = 0.0125;
    result.result.parameters.push_back(p);
  }
  std::vector<host::CoreParameter> base(26);
  result.result.parameters.insert(result.result.parameters.begin(), base.begin(), base.end());
  const test::TemporaryFolder folder("model");
  host::write_file(folder.path() / "model.yaml", host::model_yaml(result));
  host::CoreOptions options;
  host::read_model(folder.path() / "model.yaml").apply(&options);
  TEST_ASSERT_EQUAL_UINT32(1u << 0 | 1u << 9, options.effects);
  TEST_ASSERT_EQUAL_INT(2, static_cast<int>(options.terms.size()));
  TEST_ASSERT_EQUAL_INT(4, static_cast<int>(options.term_values.size()));
  for (double v : options.term_values) TEST_ASSERT_EQUAL_DOUBLE(0.0125, v);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_enabled_effects_are_found);
  RUN_TEST(test_model_file);
  return UNITY_END();
}
