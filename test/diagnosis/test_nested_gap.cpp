// The gap on folds, where an effect shows in the links between segments alone, as one of temperature does.
#include <Eigen/QR>
#include <algorithm>
#include <cstdio>
#include <vector>

#include "../support/cases.h"
#include "diagnose/nested_gap.h"
#include "linear_problem.h"

using namespace host::diagnosis;
using test::LinearRecording;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kSegments = 16, kLinkRows = 60;

/// Segments whose rows say nothing about term 0, and links of neighbours whose rows do.
struct Linked {
  LinearRecording recording;
  Problem problem;
  std::vector<Rows> links;  ///< [i]: of segments i and i + 1

  Linked(double value, int seed) {
    recording.segments = kSegments;
    recording.add("temperature", 1, 1, value);
    recording.add("shutter", 1, 1);
    recording.shape = [this](Eigen::MatrixXd* J) { J->col(recording.n_theta).setZero(); };
    test::Random random(seed);
    problem = problem_of(recording, &random);
    const int n = recording.n_theta + recording.terms();
    for (int i = 0; i + 1 < kSegments; ++i) {
      Eigen::MatrixXd rows = random.matrix(kLinkRows, n + 1);
      rows.col(n) += value * rows.col(recording.n_theta);
      links.push_back({triangle_of(rows), kLinkRows});
    }
    std::vector<std::size_t> all, half[2];
    for (std::size_t i = 0; i < kSegments; ++i) {
      all.push_back(i);
      half[is_held_out(i) ? 1 : 0].push_back(i);
    }
    problem.all = joined(all);
    problem.train = joined(half[0]);
    problem.held_out = joined(half[1]);
  }

  Rows joined(const std::vector<std::size_t>& places) const {
    std::vector<const Rows*> rows;
    for (std::size_t k = 0; k < places.size(); ++k) {
      rows.push_back(&problem.pieces[places[k]].rows);
      if (k > 0 && places[k] == places[k - 1] + 1) rows.push_back(&links[places[k - 1]]);
    }
    return sum_of(rows);
  }

  Selection selected() const {
    return select_effects(recording.candidates, {}, [this](const std::vector<int>&) { return problem; });
  }
};

Gap gap_of(const Linked& linked, const Selection& selection) {
  const JoinedRows joined = [&linked](const std::vector<std::size_t>& places) { return linked.joined(places); };
  return nested_gap(selection, folds_of(selection, joined));
}

/// 8 of 15 links are within pairs: of 60 rows and values of 0.5 each, 8 * 60 * 0.25 = 120 of chi2 in all folds, which
/// scatter by 2 sqrt(120) = 22. Every effect is found in each fold (three quarters hold at least 9 links, 135), and
/// closes it.
void test_links_are_held_out_too() {
  for (int seed = 1; seed <= 20; ++seed) {
    const Linked linked(0.5, seed);
    const Selection s = linked.selected();
    TEST_ASSERT_EQUAL_size_t(1, s.accepted.size());
    TEST_ASSERT_EQUAL_INT(0, s.accepted[0].candidate);
    const Gap gap = gap_of(linked, s);
    if (seed == 1) std::printf("gap in the links alone: %.0f, closed %.3f\n", gap.before, gap.closed());
    TEST_ASSERT_DOUBLE_WITHIN(4 * 22, 120, gap.before);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 1, gap.closed());
    const Gap apart = nested_gap(s, folds_of(s, sums_of_pieces(linked.problem.pieces)));
    TEST_ASSERT_TRUE_MESSAGE(apart.before < 1, "pieces by themselves say nothing");
  }
}

/// Nothing there: nothing is open, on average of many recordings.
void test_links_without_effect() {
  double sum = 0;
  constexpr int kRuns = 60;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const Linked linked(0, 100 + seed);
    sum += gap_of(linked, linked.selected()).before / kRuns;
  }
  TEST_ASSERT_DOUBLE_WITHIN(0.5, 0, sum);  // of chi2; nothing is accepted, so that nothing is asked
}

/// Each segment is held out once, beside its neighbour.
void test_folds_are_pairs() {
  const Linked linked(0.5, 3);
  const Selection s = linked.selected();
  std::vector<int> times(kSegments, 0);
  for (const Fold& fold : folds_of(s, sums_of_pieces(linked.problem.pieces))) {
    for (std::size_t i : fold.places) ++times[i];
    TEST_ASSERT_EQUAL_size_t(4, fold.places.size());
    TEST_ASSERT_EQUAL_size_t(kSegments - 4, fold.training.pieces.size());
    const auto held_out = std::count_if(fold.training.pieces.begin(), fold.training.pieces.end(),
                                        [](const Piece& p) { return p.held_out; });
    TEST_ASSERT_INT_WITHIN(2, kSegments / 2 - 2, static_cast<int>(held_out));
  }
  for (int n : times) TEST_ASSERT_EQUAL_INT(1, n);
}

/// At least half of the folds must choose the effect itself, or its pair; what they choose beside it says nothing.
/// Where they are too few to choose, nobody was asked.
void test_folds_confirm_each_effect() {
  const Linked linked(0.5, 4);
  Selection s = linked.selected();
  std::vector<Fold> folds = folds_of(s, [&linked](const std::vector<std::size_t>& p) { return linked.joined(p); });
  TEST_ASSERT_EQUAL_size_t(4, folds.size());
  TEST_ASSERT_TRUE(folds_confirm(s, folds, 0));
  for (std::size_t i = 0; i < 3; ++i) {  // these name the other candidate, "shutter"
    folds[i].accepted[0].candidate = 1;
    TEST_ASSERT_EQUAL(i < 2, folds_confirm(s, folds, 0));
  }
  s.pairs.push_back({0, 1});
  TEST_ASSERT_TRUE(folds_confirm(s, folds, 0));
  s.pairs.clear();
  for (Fold& fold : folds) fold.missed = true;
  TEST_ASSERT_FALSE(folds_confirm(s, folds, 0));
  for (Fold& fold : folds) fold.chooses = false;
  TEST_ASSERT_TRUE(folds_confirm(s, folds, 0));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_links_are_held_out_too);
  RUN_TEST(test_links_without_effect);
  RUN_TEST(test_folds_are_pairs);
  RUN_TEST(test_folds_confirm_each_effect);
  return UNITY_END();
}
