// Who shares a gauge with whom: union-find against a search through the graph, and partitions of segments whose tracks,
// frames, sessions and IMU joins are arranged by hand.
#include <memory>
#include <set>
#include <vector>

#include "../support/cases.h"
#include "../support/synthetic_segments.h"
#include "calibration/partitions.h"

using namespace SEGCAL_NS;
using test::Id;
using test::SyntheticSession;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// Segments that can be reached from 0 to n - 1 along the edges, by a plain search.
std::vector<int> first_reachable(int n, const std::vector<std::pair<int, int>>& edges) {
  std::vector<int> first(n);
  for (int i = 0; i < n; ++i) first[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : edges) {
      const int least = std::min(first[a], first[b]);
      changed |= first[a] != least || first[b] != least;
      first[a] = first[b] = least;
    }
  }
  return first;
}

void check_sets(const Id& id, int n, const std::vector<std::pair<int, int>>& edges) {
  DisjointSets sets;
  sets.reset(n);
  const std::vector<int> before = first_reachable(n, {});
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const std::vector<int> so_far = first_reachable(n, {edges.begin(), edges.begin() + static_cast<long>(e)});
    const bool apart = so_far[edges[e].first] != so_far[edges[e].second];
    test::check_true(id.add("edge", e), "join() told wrongly whether anything changed",
                     sets.join(edges[e].first, edges[e].second) == apart);
  }
  const std::vector<int> expected = first_reachable(n, edges);
  for (int i = 0; i < n; ++i) test::check_true(id.add("segment", i), "wrong root", sets.root(i) == expected[i]);
}

void test_union_find() {
  const int n = kMaxSegments;
  std::vector<std::pair<int, int>> chain, backwards, star, two;
  for (int i = 1; i < n; ++i) {
    chain.emplace_back(i - 1, i);
    backwards.emplace_back(n - i, n - i - 1);
    star.emplace_back(i, n / 2);
    if (i >= 2) two.emplace_back(i, i - 2);
  }
  check_sets(Id().add("shape", "none"), n, {});
  check_sets(Id().add("shape", "chain"), n, chain);
  check_sets(Id().add("shape", "backwards"), n, backwards);
  check_sets(Id().add("shape", "star"), n, star);
  check_sets(Id().add("shape", "two"), n, two);
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    test::Random random(seed);
    std::vector<std::pair<int, int>> edges;
    for (int e = random.index(2 * n); e > 0; --e) edges.emplace_back(random.index(n), random.index(n));
    check_sets(Id().add("shape", "random").add("seed", seed), n, edges);
  }
}

constexpr int kShared = 24;

/// Segments across gaps, all of which see the same 24 landmarks: tracks 0 to 23.
SyntheticSession segments_of_one_map(int segments, double gap = 2) {
  test::SyntheticOptions options;
  options.seed = 7;
  options.segments = segments;
  options.keyframes = 10;
  options.landmarks = 6;
  options.shared = kShared;
  options.gap = gap;
  return SyntheticSession(options);
}

/// Segment s knows only tracks [first, end) of the map by their names; the others become its own.
void keep_tracks(SyntheticSession* session, int s, std::uint32_t first, std::uint32_t end) {
  Segment<double>& segment = *session->segments[s];
  for (int j = 0; j < segment.n_landmarks; ++j) {
    std::uint32_t& id = segment.track_id[j];
    if (id < kShared && (id < first || id >= end)) id += 100000u * (static_cast<std::uint32_t>(s) + 1);
  }
}

struct Grouping {
  explicit Grouping(const SyntheticSession& session) : count(static_cast<int>(session.segments.size())) {
    for (int i = 0; i < count; ++i) {
      segment[i] = session.segments[i].get();
      if (i > 0) link[i] = link_after(end_of(*segment[i - 1]), *segment[i]);
    }
    partitions.form(segment, link, count, session.nominal, session.model);
  }
  std::vector<int> firsts() {
    std::vector<int> out;
    for (int i = 0; i < count; ++i) out.push_back(partitions.first_of(i));
    return out;
  }
  int ties() const { return partitions.ties().count(); }

  int count;
  Segment<double>* segment[kMaxSegments];
  SegmentLink<double> link[kMaxSegments];
  Partitions<double> partitions;
};

void check_group(const Id& id, const SyntheticSession& session, const std::vector<int>& firsts, int ties) {
  Grouping g(session);
  for (int i = 0; i < g.count; ++i)
    test::check_near(id.add("segment", i), "first of its partition", firsts[i], g.firsts()[i], 0);
  test::check_near(id, "ties", ties, g.ties(), 0);
  test::check_near(id, "partitions", static_cast<double>(std::set<int>(firsts.begin(), firsts.end()).size()),
                   g.partitions.count(), 0);
  for (int t = 0; t < g.ties(); ++t) {
    std::set<std::uint32_t> tracks;
    std::set<int> sets;
    for (int i = 0; i < g.count; ++i) {
      const int j = g.partitions.ties().landmark(t, i);
      if (j < 0) continue;
      tracks.insert(g.segment[i]->track_id[j]);
      sets.insert(g.partitions.first_of(i));
      const Landmark<double>&a = g.segment[i]->states.landmark[j],
            &b = g.segment[g.partitions.ties().first_segment(t)]
                     ->states.landmark[g.partitions.ties().landmark(t, g.partitions.ties().first_segment(t))];
      test::check_true(id.add("tie", t), "copies differ", a.o == b.o && a.m == b.m && a.rho == b.rho);
    }
    test::check_true(id.add("tie", t), "a tie is one track, within one partition",
                     tracks.size() == 1 && sets.size() == 1);
  }
}

/// Ties of n edges that have nothing in common.
constexpr int ties_of(int edges) { return edges * kTiesPerEdge; }

void test_threshold() {
  const Id id = Id().add("check", "threshold");
  SyntheticSession enough = segments_of_one_map(2), missed = segments_of_one_map(2);
  keep_tracks(&enough, 1, 0, kSharedLandmarks);
  keep_tracks(&missed, 1, 0, kSharedLandmarks - 1);
  check_group(id.add("shared", kSharedLandmarks), enough, {0, 0}, ties_of(1));
  check_group(id.add("shared", kSharedLandmarks - 1), missed, {0, 1}, 0);
}

void test_frames_and_sessions_stay_apart() {
  const Id id = Id().add("check", "apart");
  SyntheticSession frame = segments_of_one_map(2), both = segments_of_one_map(2);
  frame.segments[1]->frame = 1;
  check_group(id.add("by", "frame"), frame, {0, 1}, 0);
  both.segments[1]->session = 1;
  check_group(id.add("by", "session"), both, {0, 1}, 0);
}

void test_imu_joins_need_no_tracks() {
  SyntheticSession session = segments_of_one_map(3, 0);
  for (int s = 0; s < 3; ++s) keep_tracks(&session, s, 0, 0);
  check_group(Id().add("check", "imu"), session, {0, 0, 0}, 0);
  // Whoever is joined by the IMU needs no ties, however much the two see together.
  check_group(Id().add("check", "imu_shared"), segments_of_one_map(3, 0), {0, 0, 0}, 0);
  // The last segment shares tracks with the first one only, and belongs to the second by the IMU.
  SyntheticSession around = segments_of_one_map(3, 0);
  around.segments[1]->lead_us = 0;
  keep_tracks(&around, 1, 0, 0);
  check_group(Id().add("check", "around"), around, {0, 0, 0}, ties_of(1));
}

void test_star_needs_no_more_ties_than_an_edge() {
  check_group(Id().add("check", "star"), segments_of_one_map(5), {0, 0, 0, 0, 0}, ties_of(1));
}

void test_chain_of_two_edges() {
  SyntheticSession session = segments_of_one_map(3);
  keep_tracks(&session, 0, 0, 12);
  keep_tracks(&session, 2, 12, 24);
  const bool room = kMaxTies >= ties_of(2);
  check_group(Id().add("check", "chain"), session, {0, 0, room ? 0 : 2}, ties_of(room ? 2 : 1));
}

void test_two_groups() {
  SyntheticSession session = segments_of_one_map(4);
  for (int s = 0; s < 4; ++s) keep_tracks(&session, s, s % 2 ? 0 : 12, s % 2 ? 12 : 24);
  const bool room = kMaxTies >= ties_of(2);
  check_group(Id().add("check", "groups"), session, {0, 1, 0, room ? 1 : 3}, ties_of(room ? 2 : 1));
}

void test_more_edges_than_places() {
  // A star of bundles: segment s > 0 shares eight tracks of its own with segment 0.
  SyntheticSession session = segments_of_one_map(4);
  for (std::uint32_t s = 1; s < 4; ++s) keep_tracks(&session, static_cast<int>(s), 8 * (s - 1), 8 * s);
  const int edges = std::min(3, kMaxTies / kTiesPerEdge);
  Grouping g(session);
  test::check_near(Id().add("check", "places"), "partitions", 4 - edges, g.partitions.count(), 0);
  test::check_true(Id().add("check", "places"), "more ties than places", g.ties() <= kMaxTies);
}

/// Marks all image points of the map's tracks from `first` on as far off.
void reject_tracks(Segment<double>* segment, std::uint32_t first) {
  for (int o = 0; o < segment->n_observations; ++o) {
    const std::uint32_t id = segment->track_id[segment->observation[o].landmark];
    segment->observation[o].rejected = id >= first && id < kShared ? 1 : 0;
  }
}

/// The map's landmarks are all where the first two of them are, with their image points: nothing fixes the rotation
/// about the line through these two.
void put_map_in_two_places(Segment<double>* segment) {
  const Segment<double> was = *segment;
  int n = 0;
  for (int j = 0; j < was.n_landmarks; ++j) {
    const int from = was.track_id[j] < kShared ? landmark_of_track(was, was.track_id[j] % 2) : j;
    segment->states.landmark[j] = was.states.landmark[from];
    segment->first_observation[j] = static_cast<std::uint16_t>(n);
    for (int o = was.first_observation[from]; o < was.first_observation[from + 1]; ++o) {
      segment->observation[n] = was.observation[o];
      segment->observation[n++].landmark = static_cast<std::uint16_t>(j);
    }
  }
  segment->first_observation[was.n_landmarks] = static_cast<std::uint16_t>(n);
  segment->n_observations = n;
}

void test_too_few_good_tracks() {
  const Id id = Id().add("check", "quality");
  SyntheticSession points = segments_of_one_map(2), directions = segments_of_one_map(2), pair = segments_of_one_map(2);
  reject_tracks(points.segments[1].get(), kFewestTies - 1);
  check_group(id.add("lack", "points"), points, {0, 1}, 0);
  for (Landmark<double>& l : directions.segments[0]->states.landmark) l.rho = 1e-4;  // 10 km: no parallax at all
  check_group(id.add("lack", "parallax"), directions, {0, 1}, 0);
  for (const auto& segment : pair.segments) put_map_in_two_places(segment.get());
  check_group(id.add("lack", "spread"), pair, {0, 1}, 0);
}

/// Exchanges the names of `count` of the map's tracks in a ring.
void mistake_tracks(Segment<double>* segment, std::uint32_t count) {
  for (int j = 0; j < segment->n_landmarks; ++j) {
    std::uint32_t& id = segment->track_id[j];
    if (id < count) id = (id + 1) % count;
  }
}

void test_mistaken_tracks() {
  const Id id = Id().add("check", "mistaken");
  SyntheticSession some = segments_of_one_map(2), all = segments_of_one_map(2);
  mistake_tracks(some.segments[1].get(), kShared / 4);
  check_group(id.add("which", "some"), some, {0, 0}, ties_of(1));
  Grouping g(some);
  for (int t = 0; t < g.ties(); ++t) {
    test::check_true(id.add("tie", t), "a mistaken track is tied",
                     g.segment[0]->track_id[g.partitions.ties().landmark(t, 0)] >= kShared / 4);
  }
  mistake_tracks(all.segments[1].get(), kShared);
  check_group(id.add("which", "all"), all, {0, 1}, 0);
}

/// A store can hold any stamp: the sanitizers saw the difference overflow.
void test_a_gap_between_any_two_stamps() {
  static Segment<float> segment;
  segment.session = 1;
  segment.t0_ns = 6200000000;
  const auto link = link_after(SegmentEnd{INT64_MIN, 1, 1}, segment);
  TEST_ASSERT_TRUE(link.gap_s > 9.2e9f && link.gap_s < 9.3e9f);  // INT64_MAX, ns
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_a_gap_between_any_two_stamps);
  RUN_TEST(test_union_find);
  RUN_TEST(test_threshold);
  RUN_TEST(test_frames_and_sessions_stay_apart);
  RUN_TEST(test_imu_joins_need_no_tracks);
  RUN_TEST(test_star_needs_no_more_ties_than_an_edge);
  RUN_TEST(test_chain_of_two_edges);
  RUN_TEST(test_two_groups);
  RUN_TEST(test_more_edges_than_places);
  RUN_TEST(test_too_few_good_tracks);
  RUN_TEST(test_mistaken_tracks);
  return UNITY_END();
}
