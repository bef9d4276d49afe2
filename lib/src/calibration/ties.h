// Ties: landmarks that segments of one partition share, so that
// all of them stand in one frame (docs/design.md, section 7).
//
// A tie has one set of parameters for all segments that see it. Each keeps a copy of it among its own landmarks: the
// copies begin equal and move by the same steps, so no other code needs to know. Between two segments a few ties are
// enough: they fix position and rotation about gravity, and the rest of the shared tracks would add little to theta at
// the price of three columns each.
#pragma once

#include "calibration/disjoint_sets.h"
#include "calibration/landmark_information.h"

namespace SEGCAL_NS {

constexpr int kTiesPerEdge = 4;  ///< one more than needed, so that the loss of one leaves enough
constexpr int kFewestTies = 3;   ///< two points leave the rotation about the line through them to gravity alone
static_assert(kMaxLandmarks < 32768, "landmarks are counted in 16 bits");

/// Index of a track among a segment's landmarks; -1 if it is not there.
template <class S>
int landmark_of_track(const Segment<S>& segment, std::uint32_t id) {
  int j = segment.n_landmarks - 1;
  while (j >= 0 && segment.track_id[j] != id) --j;
  return j;
}

template <class S>
class Ties {
 public:
  void clear() { n_ = 0; }
  int count() const { return n_; }
  /// Landmark of segment i that is tie t; -1 if it does not see it.
  int landmark(int t, int i) const { return tie_[t].landmark[i]; }
  /// The first segment that sees it.
  int first_segment(int t) const {
    int i = 0;
    while (tie_[t].landmark[i] < 0) ++i;
    return i;
  }
  /// The ties that segment i sees.
  void of_segment(int i, TiedLandmarks* out) const {
    out->n = 0;
    out->total = n_;
    for (int t = 0; t < n_; ++t) {
      if (tie_[t].landmark[i] < 0) continue;
      out->landmark[out->n] = tie_[t].landmark[i];
      out->number[out->n++] = static_cast<std::int16_t>(t);
    }
  }

  /// Chooses ties between segments a and b of different sets.
  /// False, and nothing is changed, if too few are good enough.
  [[gnu::cold]] bool connect(Segment<S>* const* segment, int a, int b, const Calibration<S>& theta,
                             const MeasurementModel<S>& model, DisjointSets* sets);
  /// When all sets are joined: every segment of a tie's set that sees it takes part, and begins with the same values.
  [[gnu::cold]] void spread(Segment<S>* const* segment, int count, DisjointSets* sets);

 private:
  struct Tie {
    std::uint32_t id;
    std::int32_t home;  ///< the segment that knows it best
    std::int16_t landmark[kMaxSegments];
  };
  struct Candidate {
    Vec3<S> place, in_b;  ///< in the frames of the two segments: equal but for drift
    S information;        ///< about its distance, in the segment that knows less
    std::uint32_t id;
    std::int16_t home;
    bool exists, taken;
  };
  bool exists(std::uint32_t id, int a, int b, DisjointSets* sets) const;
  [[gnu::cold]] int collect(Segment<S>* const* segment, int a, int b, const Calibration<S>& theta,
                            const MeasurementModel<S>& model, DisjointSets* sets, Candidate* out) const;
  [[gnu::cold]] static int drop_mistaken(Candidate* candidate, int n);
  [[gnu::cold]] static S worth(const Candidate* candidate, int n, int i, const Vec3<S>& up);
  void remove_doubles(DisjointSets* sets);

  Tie tie_[kMaxTies + 1];
  std::int32_t n_ = 0;
};

template <class S>
bool Ties<S>::exists(std::uint32_t id, int a, int b, DisjointSets* sets) const {
  for (int t = 0; t < n_; ++t) {
    if (tie_[t].id == id && (sets->same(tie_[t].home, a) || sets->same(tie_[t].home, b))) return true;
  }
  return false;
}

/// Tracks that both segments see and whose distance both know.
template <class S>
int Ties<S>::collect(Segment<S>* const* segment, int a, int b, const Calibration<S>& theta,
                     const MeasurementModel<S>& model, DisjointSets* sets, Candidate* out) const {
  int n = 0;
  for (int i = 0; i < segment[a]->n_landmarks; ++i) {
    const std::uint32_t id = segment[a]->track_id[i];
    const int j = landmark_of_track(*segment[b], id);
    if (j < 0) continue;
    const S of_a = distance_information(*segment[a], i, theta, model),
            of_b = distance_information(*segment[b], j, theta, model);
    if (!(of_a > S(0) && of_b > S(0))) continue;
    const Landmark<S>&in_a = segment[a]->states.landmark[i], &in_b = segment[b]->states.landmark[j];
    out[n++] = {in_a.o + in_a.m / in_a.rho,
                in_b.o + in_b.m / in_b.rho,
                of_a < of_b ? of_a : of_b,
                id,
                static_cast<std::int16_t>(of_b > of_a ? b : a),
                exists(id, a, b, sets),
                false};
  }
  return drop_mistaken(out, n);
}

/// Landmarks keep their distances from each other, whatever the drift between two segments: a track that is another one
/// in the second segment fits few of the rest. Those that do not fit half of them go. Returns how many stay.
template <class S>
int Ties<S>::drop_mistaken(Candidate* candidate, int n) {
  for (int i = 0; i < n; ++i) {
    int fits = 0;
    for (int k = 0; k < n; ++k) {
      if (k == i) continue;
      const Candidate &p = candidate[i], &q = candidate[k];
      const S in_a = square_root((p.place - q.place).squaredNorm()),
              in_b = square_root((p.in_b - q.in_b).squaredNorm());
      // A tenth for what the calibration and the poses are still off, and some three sigmas of either place.
      const S larger = in_a > in_b ? in_a : in_b;
      const S allowed2 = S(0.01) * larger * larger + S(10) / p.information + S(10) / q.information;
      fits += (in_a - in_b) * (in_a - in_b) <= allowed2 ? 1 : 0;
    }
    candidate[i].taken = 2 * fits < n - 1;
  }
  int kept = 0;
  for (int i = 0; i < n; ++i) {
    if (!candidate[i].taken) candidate[kept++] = candidate[i];
  }
  return kept;
}

/// Squared horizontal distance from the nearest tie taken so far, in sigmas: that is what fixes the rotation about
/// gravity. For the first one, what it says about position. 0 if it adds too little.
template <class S>
S Ties<S>::worth(const Candidate* candidate, int n, int i, const Vec3<S>& up) {
  S nearest = S(-1);
  for (int k = 0; k < n; ++k) {
    if (!candidate[k].taken) continue;
    const Vec3<S> d = candidate[k].place - candidate[i].place;
    const S along = d.dot(up), horizontal = d.squaredNorm() - along * along;
    if (nearest < S(0) || horizontal < nearest) nearest = horizontal;
  }
  if (nearest < S(0)) return candidate[i].information;
  const S worth = nearest * candidate[i].information;
  return worth < kKnownDistance2<S> ? S(0) : worth;
}

template <class S>
bool Ties<S>::connect(Segment<S>* const* segment, int a, int b, const Calibration<S>& theta,
                      const MeasurementModel<S>& model, DisjointSets* sets) {
  int room = kMaxTies - n_, near = 0;
  for (int t = 0; t < n_; ++t) near += sets->same(tie_[t].home, a) || sets->same(tie_[t].home, b) ? 1 : 0;
  if (room + near < kFewestTies) return false;
  Candidate candidate[kMaxLandmarks];
  const int n = collect(segment, a, b, theta, model, sets, candidate);
  const Vec3<S> up = model.g / -square_root(model.g.squaredNorm());
  int taken = 0;
  for (; taken < kTiesPerEdge; ++taken) {
    int best = -1;
    S most = S(0);
    // Ties that exist already cost nothing more: they come first.
    for (int i = 0; i < n; ++i) {
      if (candidate[i].taken || (!candidate[i].exists && room == 0)) continue;
      const S value = worth(candidate, n, i, up);
      if (!(value > S(0)) || (best >= 0 && candidate[best].exists && !candidate[i].exists)) continue;
      if (best >= 0 && candidate[best].exists == candidate[i].exists && !(value > most)) continue;
      best = i;
      most = value;
    }
    if (best < 0) break;
    candidate[best].taken = true;
    room -= candidate[best].exists ? 0 : 1;
  }
  if (taken < kFewestTies) return false;
  for (int i = 0; i < n; ++i) {
    if (!candidate[i].taken || candidate[i].exists) continue;
    tie_[n_].id = candidate[i].id;
    tie_[n_++].home = candidate[i].home;
  }
  return true;
}

/// A track that was a tie in each of two sets before they were joined is one landmark now.
template <class S>
void Ties<S>::remove_doubles(DisjointSets* sets) {
  int kept = 0;
  for (int t = 0; t < n_; ++t) {
    bool known = false;
    for (int u = 0; u < kept; ++u) known |= tie_[u].id == tie_[t].id && sets->same(tie_[u].home, tie_[t].home);
    if (!known) tie_[kept++] = tie_[t];
  }
  n_ = kept;
}

template <class S>
void Ties<S>::spread(Segment<S>* const* segment, int count, DisjointSets* sets) {
  remove_doubles(sets);
  for (int t = 0; t < n_; ++t) {
    Tie& tie = tie_[t];
    const Segment<S>& home = *segment[tie.home];
    const Landmark<S> value = home.states.landmark[landmark_of_track(home, tie.id)];
    for (int i = 0; i < count; ++i) {
      const int j = sets->same(i, tie.home) ? landmark_of_track(*segment[i], tie.id) : -1;
      tie.landmark[i] = static_cast<std::int16_t>(j);
      if (j >= 0) segment[i]->states.landmark[j] = value;
    }
  }
}

}  // namespace SEGCAL_NS
