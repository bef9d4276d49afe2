// The filter's start as background work (profile mcu): it takes effect at a fixed time, with the same bits whatever the
// slices, and no frame does more than a share of the features.
#include <unity.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "api/result_hash.h"
#include "vio_simulation.h"

using namespace vio_test;

void setUp(void) {}
void tearDown(void) {}

namespace {

using Real = SEGCAL_REAL;

Scene in_motion(int seed) {
  Scene scene;
  scene.seed = static_cast<std::uint64_t>(seed);
  scene.seconds = 8;
  scene.tracks = kMaxVioTracks;
  return scene;
}

struct Outcome {
  std::uint64_t hash = 0;
  double first_tracking = -1;  ///< s
  double worst_position = 0;   ///< m, from where it started
  int most_features = 0;       ///< in one frame
  VioStatistics statistics;
};

struct Span {
  double from, until;  ///< s
};

/// Feeds samples and frames, with so many slices of the start after each of them. Frames in `blind` are withheld.
Outcome run(const Scene& scene, int slices, const std::vector<Span>& blind = {}) {
  const Recording recording = simulate(scene);
  auto vio = std::make_unique<Vio<Real>>();
  auto history = std::make_unique<ImuHistory<Real>>();
  history->clear();
  vio->reset(cast<Real>(recording.initial), options_for<Real>(scene));
  Outcome out;
  Hash hash;
  Gauge gauge;
  std::size_t next = 0;
  const auto work = [&] {
    for (int i = 0; i < slices && vio->start_pending(); ++i) vio->start_step(*history);
  };
  for (const TrueFrame& frame : recording.frames) {
    for (; next < recording.imu.size() && recording.imu_time[next] <= frame.t_ns; ++next) {
      history->push(recording.imu_time[next],
                    {recording.imu[next].gyro.cast<Real>(), recording.imu[next].accel.cast<Real>()});
      work();
    }
    const double t = static_cast<double>(frame.t_ns - 1000000000) * 1e-9;
    if (std::any_of(blind.begin(), blind.end(), [t](const Span& s) { return t > s.from && t < s.until; })) continue;
    std::vector<TrackPoint<Real>> points;
    for (const TrackPoint<double>& p : frame.points) points.push_back({p.id, p.camera, p.uv.cast<Real>()});
    const VioStatistics before = vio->statistics();
    const VioStatus status = vio->push_frame(frame.t_ns, points.data(), static_cast<int>(points.size()), *history);
    work();
    if (status != VioStatus::tracking) continue;
    const VioStatistics& now = vio->statistics();
    hash.add(frame.t_ns);
    add_to_hash(vio->state(), &hash);
    if (out.first_tracking < 0) {
      out.first_tracking = t;
      gauge.fix(vio->window().newest(), frame.x);
      continue;
    }
    out.most_features = std::max(out.most_features, now.updates + now.gated - before.updates - before.gated);
    out.worst_position = std::max(out.worst_position, gauge.error(vio->state(), frame.x).segment<3>(3).norm());
  }
  out.hash = hash.value();
  out.statistics = vio->statistics();
  return out;
}

void say(const char* what, int seed, int slices, const Outcome& out) {
  char line[160];
  std::snprintf(line, sizeof line, "%s: seed %d, %d slices: from %.1f s, worst %.3f m, starts %d, late %d, restarts %d",
                what, seed, slices, out.first_tracking, out.worst_position, static_cast<int>(out.statistics.starts),
                static_cast<int>(out.statistics.late_starts), static_cast<int>(out.statistics.restarts));
  TEST_MESSAGE(line);
}

void the_same_bits_whatever_the_slices(void) {
  for (int seed = 1; seed <= 4; ++seed) {
    const Outcome at_once = run(in_motion(seed), 0);
    TEST_ASSERT_EQUAL_INT(1, at_once.statistics.late_starts);  // nobody did the slices: the frame did
    for (int slices : {1, 7, 100000}) {
      const Outcome out = run(in_motion(seed), slices);
      if (out.hash != at_once.hash) say("other bits", seed, slices, out);
      TEST_ASSERT_TRUE(out.hash == at_once.hash);
      if (slices == 100000) TEST_ASSERT_EQUAL_INT(0, out.statistics.late_starts);
    }
  }
}

/// Nine frames, as many as the window holds, are collected by 0.9 s; half a second later, at the first frame that is
/// not before, the start takes effect. A hard scene may need a second try, with nine new frames.
void it_starts_and_stays_on_its_path(void) {
  int at_first = 0;
  for (int seed = 1; seed <= 16; ++seed) {
    const Outcome out = run(in_motion(seed), 7);
    say("start", seed, 7, out);
    TEST_ASSERT_TRUE_MESSAGE(out.first_tracking > 0.9 + SEGCAL_START_DELAY_MS * 1e-3 - 0.05,
                             "earlier than the start may take effect");
    TEST_ASSERT_TRUE_MESSAGE(out.first_tracking < 2 * (0.9 + SEGCAL_START_DELAY_MS * 1e-3) + 0.05, "started late");
    TEST_ASSERT_EQUAL_INT(0, out.statistics.restarts);
    TEST_ASSERT_TRUE_MESSAGE(out.worst_position < 0.2,
                             "far from the path");  // as starts in one call: 0.15 m over 20 s, 60 tracks
    at_first += out.first_tracking < 0.95 + SEGCAL_START_DELAY_MS * 1e-3 ? 1 : 0;
  }
  TEST_ASSERT_TRUE_MESSAGE(at_first >= 12, "most starts succeed at their first try");
}

/// Hardly a frame comes until the history of 1.5 s has lost the start's first samples: what was done is thrown away, in
/// slices or not, and nine new frames are collected. Gaps of up to 0.6 s would be survived otherwise.
void lost_samples_cancel_it(void) {
  const Outcome kept = run(in_motion(2), 100000, {{0.95, 1.15}, {1.25, 1.45}});
  TEST_ASSERT_TRUE_MESSAGE(kept.first_tracking < 1.55, "the start was lost for no reason");
  const std::vector<Span> blind = {{0.95, 1.15}, {1.25, 1.65}};
  const Outcome lost = run(in_motion(2), 100000, blind);
  TEST_ASSERT_TRUE_MESSAGE(lost.first_tracking > 2.35, "a window of older frames was used");
  TEST_ASSERT_TRUE(run(in_motion(2), 0, blind).hash == lost.hash);
  // No frame at all until then: the filter begins anew without a word to the start, whose slices are all done.
  const std::vector<Span> dark = {{0.95, 2.45}};
  TEST_ASSERT_TRUE(run(in_motion(2), 0, dark).hash == run(in_motion(2), 100000, dark).hash);
}

/// All tracks of a first window are due in one frame when its oldest pose leaves: most wait. The shortest features cost
/// an eighth of a full one; without a bound there would be 30 of them.
void a_frame_does_its_share_of_features(void) {
  for (int seed = 1; seed <= 4; ++seed) {
    const Outcome out = run(in_motion(seed), 7);
    if (out.most_features > 2 * SEGCAL_FRAME_FEATURES + 4) say("too many features", seed, 7, out);
    TEST_ASSERT_TRUE(out.most_features <= 2 * SEGCAL_FRAME_FEATURES + 4);
  }
}

}  // namespace

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(the_same_bits_whatever_the_slices);
  RUN_TEST(it_starts_and_stays_on_its_path);
  RUN_TEST(lost_samples_cancel_it);
  RUN_TEST(a_frame_does_its_share_of_features);
  return UNITY_END();
}
