// What a stored device and this one must have in common.
#include <unity.h>

#include <memory>
#include <vector>

#include "store/stored_options.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace SEGCAL_NS;
using Options = DeviceOptions<double>;

std::vector<std::uint8_t> identity_of(Options* options) {
  Fields size;
  StoredOptions<double>::identity(&size, options);
  std::vector<std::uint8_t> out(size.size());
  Fields reads(0, out.data(), size.size());
  StoredOptions<double>::identity(&reads, options);
  return out;
}

/// The name of the first field that differs; empty: none does.
std::string difference(Options* options, const std::vector<std::uint8_t>& stored) {
  Fields compares(Fields::Does::compares, 0, stored.data(), static_cast<std::uint32_t>(stored.size()));
  StoredOptions<double>::identity(&compares, options);
  return compares.difference() ? compares.difference() : "";
}

/// All capacities stand at the front, as SEGCAL_CAPACITIES lists them, 32 bits each; all must be the same but the
/// number of columns for effects, in which builds may differ that read each other's stores.
void test_capacities() {
  const auto options = std::make_unique<Options>();
  options->prior.mean = Calibration<double>();
  const std::vector<std::uint8_t> stored = identity_of(options.get());
  TEST_ASSERT_EQUAL_STRING("", difference(options.get(), stored).c_str());
  const std::uint32_t listed[SEGCAL_N_CAPACITIES] = SEGCAL_CAPACITIES;
  TEST_ASSERT_EQUAL_MEMORY(listed, stored.data(), sizeof listed);
  TEST_ASSERT_EQUAL_UINT32(SEGCAL_MAX_EFFECT_COLUMNS, listed[kEffectColumnsCapacity]);
  for (int i = 0; i < SEGCAL_N_CAPACITIES; ++i) {
    std::vector<std::uint8_t> other = stored;
    ++other[4 * static_cast<std::size_t>(i)];
    TEST_ASSERT_EQUAL_STRING(i == kEffectColumnsCapacity ? "" : "capacities", difference(options.get(), other).c_str());
  }
}

/// The fields behind the capacities are still compared where they stand.
void test_configuration() {
  const auto options = std::make_unique<Options>();
  options->prior.mean = Calibration<double>();
  const std::vector<std::uint8_t> stored = identity_of(options.get());
  options->keep_segments += 1;
  TEST_ASSERT_EQUAL_STRING("keep_segments", difference(options.get(), stored).c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_capacities);
  RUN_TEST(test_configuration);
  return UNITY_END();
}
