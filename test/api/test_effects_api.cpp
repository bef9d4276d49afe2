// Effects through the C API: score tests on the device, rows for diagnosis, configurations that must be refused.
#include <vector>

#include "api_fixture.h"

using namespace test;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kSensitivity = 5e-4;  // rad s/m: gyroscope x follows force y

/// A device that has lived the stream, its gyroscope with or without g-sensitivity.
segcal_t* lived(Storage* storage, const segcal_config_t& config, double sensitivity) {
  segcal_t* device = create(storage, config);
  for (std::size_t i = 0; i < stream().imu.size(); ++i) {
    segcal_imu_t sample = stream().imu[i];
    sample.gyro[0] += static_cast<float>(sensitivity * sample.accel[1]);
    segcal_push_imu(device, &sample);
    if (i % 20 == 0 && i / 20 < stream().frames.size()) push_frame(device, stream().frames[i / 20], Way::keyframes);
  }
  segcal_flush(device);
  return device;
}

std::vector<segcal_effect_score_t> scores(double sensitivity) {
  segcal_config_t config = SyntheticStream::config();
  config.watch_effects = SEGCAL_EFFECT_TIME_OFFSET | SEGCAL_EFFECT_GYRO_G_SENSITIVITY | SEGCAL_EFFECT_ACCEL_TEMPERATURE;
  config.trigger_fraction = -1;  // a calibration of the device's own would begin the statistics anew
  Storage storage(0xFF);
  segcal_t* device = lived(&storage, config, sensitivity);
  std::vector<segcal_effect_score_t> out(SEGCAL_EFFECTS);
  out.resize(segcal_get_effect_scores(device, out.data(), SEGCAL_EFFECTS));
  return out;
}

void test_scores_name_what_is_missing() {
  const std::vector<segcal_effect_score_t> healthy = scores(0), sick = scores(kSensitivity);
  TEST_ASSERT_EQUAL_INT(3, static_cast<int>(sick.size()));
  TEST_ASSERT_EQUAL_INT(0, sick[0].effect);
  TEST_ASSERT_EQUAL_INT(4, sick[1].effect);
  TEST_ASSERT_EQUAL_INT(9, sick[1].n_parameters);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(3, sick[1].segments);
  // Nothing was warmed: no direction of its own.
  TEST_ASSERT_EQUAL_INT(0, sick[2].dof);
  TEST_ASSERT_EQUAL_DOUBLE(0, sick[2].statistic);
  // Chi-square with nine degrees of freedom exceeds 28 once in a thousand; the states are the true ones.
  check_between(Id().add("effect", "none"), "g-sensitivity", 0, healthy[1].statistic, 28);
  check_between(Id().add("effect", "none"), "time offset", 0, healthy[0].statistic, 11);
  check_between(Id().add("effect", "g"), "g-sensitivity", 60, sick[1].statistic, 1e9);
  for (int i = 0; i < 9; ++i) {
    const double truth = i == 1 ? kSensitivity : 0;
    check_between(Id().add("effect", "g").add("parameter", i), "error / sigma", -4,
                  (sick[1].estimate[i] - truth) / sick[1].sigma[i], 4);
  }
}

/// Rows of the kept segments after a calibration: the score from them is large where the effect is, and the same rows
/// say so whatever was asked before.
void test_rows_for_diagnosis() {
  Storage storage(0xFF);
  segcal_t* device = lived(&storage, SyntheticStream::config(), kSensitivity);
  segcal_calibrate(device);
  segcal_result_t before, after;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &before));
  segcal_term_t term[SEGCAL_EFFECT_PARAMETERS];
  TEST_ASSERT_EQUAL_INT(9, segcal_effect_terms(4, term));
  std::uint8_t use[SEGCAL_MAX_SEGMENTS + 1] = {};
  int used = 0;
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    segcal_segment_t s;
    use[slot] = segcal_get_segment(device, slot, &s) == SEGCAL_OK && s.kept ? 1 : 0;
    used += use[slot];
  }
  TEST_ASSERT_EQUAL_INT(2, used);
  std::vector<double> first(3000), second(3000);
  int n_theta = 0, n_terms = 0, dof = 0;
  const auto rows = [&](std::vector<double>* out) {
    return segcal_linearise(device, use, term, 9, out->data(), static_cast<int>(out->size()), &n_theta, &n_terms, &dof);
  };
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, rows(&first));
  TEST_ASSERT_EQUAL_INT(26, n_theta);
  TEST_ASSERT_EQUAL_INT(9, n_terms);
  TEST_ASSERT_GREATER_THAN_INT(500, dof);
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, rows(&second));
  TEST_ASSERT_EQUAL_MEMORY(first.data(), second.data(), sizeof(double) * 36 * 37 / 2);
  segcal_get_result(device, &after);
  TEST_ASSERT_EQUAL_MEMORY(&before, &after, sizeof before);
  // Rows below theta's: their right-hand side is what the nine explain, theta free and without its prior.
  const auto entry = [&](int i, int c) { return first[i * 36 - i * (i - 1) / 2 + c - i]; };
  double statistic = 0;
  for (int i = 26; i < 35; ++i) statistic += entry(i, 35) * entry(i, 35);
  check_between(Id().add("rows", "kept"), "statistic", 60, statistic, 1e9);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_linearise(device, use, term, 9, first.data(), 36 * 37 / 2 - 1,
                                                            &n_theta, &n_terms, &dof));
  use[SEGCAL_MAX_SEGMENTS] = 1;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, rows(&second));
}

/// Profile mobile has room for all effects of the catalogue at once: `segcal diagnose` asks so.
void test_the_whole_catalogue_at_once() {
  Storage storage(0xFF);
  segcal_t* device = lived(&storage, SyntheticStream::config(), kSensitivity);
  segcal_calibrate(device);
  std::vector<segcal_term_t> terms;
  for (int e = 0; e < SEGCAL_EFFECTS; ++e) {
    segcal_term_t of_effect[SEGCAL_EFFECT_PARAMETERS];
    const int n = segcal_effect_terms(e, of_effect);
    terms.insert(terms.end(), of_effect, of_effect + n);
  }
  std::uint8_t use[SEGCAL_MAX_SEGMENTS + 1] = {};
  for (int slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) {
    segcal_segment_t s;
    use[slot] = segcal_get_segment(device, slot, &s) == SEGCAL_OK && s.kept ? 1 : 0;
  }
  std::vector<double> rows(5000);
  int n_theta = 0, n_terms = 0, dof = 0;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK,
                        segcal_linearise(device, use, terms.data(), static_cast<int>(terms.size()), rows.data(),
                                         static_cast<int>(rows.size()), &n_theta, &n_terms, &dof));
  TEST_ASSERT_EQUAL_INT(terms.size(), n_terms);
}

/// Estimated effects stand behind theta, with names and units.
void test_estimated_effects_in_the_result() {
  segcal_config_t config = SyntheticStream::config();
  config.estimate_effects = SEGCAL_EFFECT_GYRO_G_SENSITIVITY | SEGCAL_EFFECT_TIME_OFFSET;
  config.n_terms = 1;
  config.term[0] = {SEGCAL_TERM_ACCEL_Z, SEGCAL_SIGNAL_WX, SEGCAL_SIGNAL_WY, 0};
  Storage storage(0xFF);
  segcal_t* device = lived(&storage, config, kSensitivity);
  segcal_calibrate(device);
  segcal_result_t r;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_result(device, &r));
  TEST_ASSERT_EQUAL_INT(26 + 11, r.n_parameters);
  TEST_ASSERT_EQUAL_STRING("time_offset.t_d", r.parameter[26].name);
  TEST_ASSERT_EQUAL_STRING("gyro_g_sensitivity.xy", r.parameter[28].name);
  TEST_ASSERT_EQUAL_STRING("rad s/m", r.parameter[28].unit);
  TEST_ASSERT_EQUAL_STRING("accel_z:wx*wy", r.parameter[36].name);
  TEST_ASSERT_EQUAL_STRING("rad^-2 m", r.parameter[36].unit);
  check_between(Id().add("effect", "g"), "error / sigma", -4,
                (r.parameter[28].value - kSensitivity) / r.parameter[28].sigma, 4);
}

void check_refused(const char* what, void (*spoil)(segcal_config_t*)) {
  segcal_config_t config = SyntheticStream::config();
  spoil(&config);
  Storage storage(0);
  segcal_t* device = nullptr;
  check_near(Id().add("config", what), "code", SEGCAL_ERROR_CONFIG,
             segcal_create(&device, &config, storage.data, segcal_storage_bytes()), 0);
}

void test_configuration_is_checked() {
  check_refused("effect", [](segcal_config_t* c) { c->estimate_effects = 1u << SEGCAL_EFFECTS; });
  check_refused("watch", [](segcal_config_t* c) { c->watch_effects = 1u << SEGCAL_EFFECTS; });
  check_refused("terms", [](segcal_config_t* c) { c->n_terms = SEGCAL_MAX_EFFECT_ESTIMATES + 1; });
  check_refused("kind", [](segcal_config_t* c) { c->n_terms = 1, c->term[0].kind = SEGCAL_TERM_CAMERA_WARMTH + 1; });
  check_refused("camera_warmth", [](segcal_config_t* c) {
    c->n_terms = 1, c->term[0] = {SEGCAL_TERM_CAMERA_WARMTH, 6, 0, 0};  // 0 to 5 are r_CI, f, cx, cy
  });
  check_refused("signal", [](segcal_config_t* c) { c->n_terms = 1, c->term[0].a = SEGCAL_SIGNAL_SIN_HEADING + 1; });
  check_refused("twice", [](segcal_config_t* c) {
    c->estimate_effects = SEGCAL_EFFECT_TIME_OFFSET;
    c->n_terms = 1;
    segcal_effect_terms(0, &c->term[0]);
  });
  check_refused("value", [](segcal_config_t* c) {
    c->estimate_effects = SEGCAL_EFFECT_TIME_OFFSET;
    c->term_value[0] = std::nan("");
  });
  check_refused("height", [](segcal_config_t* c) { c->camera[0].height = -100001; });
}

/// Columns of a shutter that runs across the image come back as they were stated.
void test_lines_of_the_shutter() {
  for (const std::int32_t height : {480, -640, -751}) {
    segcal_config_t config = SyntheticStream::config();
    config.camera[0].height = height;
    Storage storage(0);
    segcal_t* device = nullptr;
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, storage.data, segcal_storage_bytes()));
    segcal_camera_t camera;
    TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_get_camera(device, 0, &camera));
    TEST_ASSERT_EQUAL_INT32(height, camera.height);
  }
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_scores_name_what_is_missing);
  RUN_TEST(test_rows_for_diagnosis);
  RUN_TEST(test_the_whole_catalogue_at_once);
  RUN_TEST(test_estimated_effects_in_the_result);
  RUN_TEST(test_configuration_is_checked);
  RUN_TEST(test_lines_of_the_shutter);
  return UNITY_END();
}
