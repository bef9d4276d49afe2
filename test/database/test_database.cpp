// What the database keeps: the best N of a stream, by session strategy, in a ring of N + 1 slots.
#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "database/database.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr float kLeastGain = 5;

Database<float>& database() {
  static Database<float> instance;
  return instance;
}

/// A segment as scoring leaves it, with a different order by each metric.
struct Offer {
  std::uint32_t serial, session;
  float A, D, E, gain;
};

bool offer(const Offer& o) {
  Segment<float>& s = database().building();
  s.serial = o.serial;
  s.session = o.session;
  s.metrics = Metrics<float>{o.A, o.D, o.E, o.gain, 20};
  return database().offer();
}

std::vector<Offer> stream(int count, std::uint32_t seed) {
  test::Random random(seed);
  std::vector<Offer> offers;
  for (int i = 0; i < count; ++i) {
    offers.push_back({static_cast<std::uint32_t>(i), 0, static_cast<float>(random.uniform(1, 26)),
                      static_cast<float>(random.uniform(-90, 10)), static_cast<float>(random.uniform(0.1, 1)), 30});
  }
  return offers;
}

float value(const Offer& o, Metric metric) { return metric == Metric::A ? o.A : metric == Metric::D ? o.D : o.E; }

std::set<std::uint32_t> kept_serials() {
  std::set<std::uint32_t> serials;
  for (int i = 0; i < Database<float>::kSlots; ++i) {
    if (database().kept(i)) serials.insert(database().slot(i).serial);
  }
  return serials;
}

std::set<std::uint32_t> best_serials(std::vector<Offer> offers, int count, Metric metric) {
  std::sort(offers.begin(), offers.end(),
            [&](const Offer& a, const Offer& b) { return value(a, metric) < value(b, metric); });
  std::set<std::uint32_t> serials;
  for (int i = 0; i < std::min<int>(count, static_cast<int>(offers.size())); ++i) serials.insert(offers[i].serial);
  return serials;
}

void test_keeps_the_best_of_a_stream() {
  for (Metric metric : {Metric::A, Metric::D, Metric::E}) {
    for (int capacity : {1, 3, 8, SEGCAL_MAX_SEGMENTS}) {
      database().reset(capacity, metric, Strategy::single_session, kLeastGain, 1);
      const std::vector<Offer> offers = stream(120, 150 + capacity);
      std::vector<Offer> seen;
      for (const Offer& o : offers) {
        offer(o);
        seen.push_back(o);
        const Id id =
            Id().add("check", "best").add("metric", int(metric)).add("capacity", capacity).add("after", seen.size());
        test::check_true(id, "not the best set", kept_serials() == best_serials(seen, capacity, metric));
      }
    }
  }
}

void test_ring_has_one_slot_for_building() {
  database().reset(SEGCAL_MAX_SEGMENTS, Metric::A, Strategy::single_session, kLeastGain, 1);
  TEST_ASSERT_EQUAL_INT(SEGCAL_MAX_SEGMENTS + 1, Database<float>::kSlots);
  for (const Offer& o : stream(100, 160)) {
    offer(o);
    // The open segment never overwrites a kept one.
    for (int i = 0; i < Database<float>::kSlots; ++i) {
      TEST_ASSERT_FALSE(database().kept(i) && &database().slot(i) == &database().building());
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(SEGCAL_MAX_SEGMENTS, database().size());
  }
  TEST_ASSERT_TRUE(database().full());
}

void test_least_gain() {
  database().reset(4, Metric::A, Strategy::single_session, kLeastGain, 1);
  TEST_ASSERT_FALSE(offer({0, 0, 1, 1, 1, kLeastGain - 0.1f}));
  TEST_ASSERT_EQUAL_INT(0, database().size());
  TEST_ASSERT_TRUE(offer({1, 0, 1, 1, 1, kLeastGain + 0.1f}));
  TEST_ASSERT_EQUAL_INT(1, database().size());
}

void test_not_a_number_is_never_kept() {
  database().reset(4, Metric::A, Strategy::single_session, kLeastGain, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  TEST_ASSERT_FALSE(offer({0, 0, nan, 1, 1, 30}));
  TEST_ASSERT_FALSE(offer({1, 0, infinity, 1, 1, 30}));
  TEST_ASSERT_EQUAL_INT(0, database().size());
}

void test_equal_values_keep_the_first() {
  database().reset(2, Metric::A, Strategy::single_session, kLeastGain, 1);
  for (std::uint32_t i = 0; i < 5; ++i) offer({i, 0, 7, 1, 1, 30});
  TEST_ASSERT_TRUE(kept_serials() == (std::set<std::uint32_t>{0, 1}));
}

void offer_two_sessions(Strategy strategy) {
  database().reset(3, Metric::A, strategy, kLeastGain, 1);
  for (std::uint32_t i = 0; i < 4; ++i) offer({i, 0, 1.0f + float(i), 1, 1, 30});  // 1 2 3 4
  database().begin_session();
  for (std::uint32_t i = 4; i < 7; ++i) offer({i, 1, 6.5f - float(i), 1, 1, 30});  // 2.5 1.5 0.5
}

void test_single_session_forgets() {
  offer_two_sessions(Strategy::single_session);
  TEST_ASSERT_TRUE(kept_serials() == (std::set<std::uint32_t>{4, 5, 6}));
}

void test_multi_session_keeps_the_best_of_all() {
  offer_two_sessions(Strategy::multi_session);
  TEST_ASSERT_TRUE(kept_serials() == (std::set<std::uint32_t>{0, 5, 6}));
}

void test_neighbours_come_in_order() {
  database().reset(8, Metric::A, Strategy::multi_session, kLeastGain, 1);
  for (const Offer& o : stream(60, 170)) offer(o);
  Segment<float>* ordered[SEGCAL_MAX_SEGMENTS];
  const int count = database().in_order(ordered);
  TEST_ASSERT_EQUAL_INT(8, count);
  for (int i = 1; i < count; ++i) TEST_ASSERT_TRUE(ordered[i - 1]->serial < ordered[i]->serial);
}

std::set<std::uint32_t> random_set(std::uint64_t seed, int count) {
  database().reset(5, Metric::random, Strategy::single_session, kLeastGain, seed);
  for (const Offer& o : stream(count, 180)) offer(o);
  return kept_serials();
}

void test_random_is_the_same_for_a_seed() {
  TEST_ASSERT_TRUE(random_set(7, 40) == random_set(7, 40));
  TEST_ASSERT_FALSE(random_set(7, 40) == random_set(8, 40));
}

void test_random_is_fair() {
  // Each of 40 segments stays with probability 1/8: 4000 runs give 500 +- 21 each, five of those. Seeds next to each
  // other must do, since users count them up.
  std::vector<int> counts(40);
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    for (std::uint32_t serial : random_set(seed, 40)) ++counts[serial];
  }
  for (int i = 0; i < 40; ++i)
    test::check_between(Id().add("check", "fair").add("serial", i), "times kept", 395, counts[i], 605);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_keeps_the_best_of_a_stream);
  RUN_TEST(test_ring_has_one_slot_for_building);
  RUN_TEST(test_least_gain);
  RUN_TEST(test_not_a_number_is_never_kept);
  RUN_TEST(test_equal_values_keep_the_first);
  RUN_TEST(test_single_session_forgets);
  RUN_TEST(test_multi_session_keeps_the_best_of_all);
  RUN_TEST(test_neighbours_come_in_order);
  RUN_TEST(test_random_is_the_same_for_a_seed);
  RUN_TEST(test_random_is_fair);
  return UNITY_END();
}
