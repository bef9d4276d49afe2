// Which of the candidate effects do the rows call for? Forward steps with a refit, a backward step, pairs that this
// motion does not tell apart, and "cannot tell" where an effect would not have shown.
//
// Statistics. With theta and the accepted effects free, the rows of a candidate e are R_ee c = d_e (rows.h,
// Marginal). In units of the candidate's plausible sizes, R_ee diag(size) = U diag(g) V': a direction with
// gain g has been seen g times better than the effect is large. Only directions with g >= kSeen count: s =
// sum (u_i' d)^2 over these, chi-square with as many degrees of freedom. None: cannot tell. s is divided by
// the dispersion, chi2/dof of the model so far, where that is above the known noise: errors that nobody has
// a name for must not look like an effect. And it is judged against the scatter of the effect's own value
// from segment to segment, when it is taken and each time that it is asked whether it stays (judge_effect):
// with values c + w_k, w_k ~ N(0, W), the mean square of c over that of the scatter is Fisher's F.
//
// A name needs more than a large s:
//  - log10 p below the recording's error level, shared out among all hypotheses beforehand (decision.h);
//  - both halves of the recording tell the same value: |c_T - c_H|^2 in units of its covariance is chi-square;
//  - the value from one half lowers the cost of the other half, in sum over both by a quarter of s at least.
#pragma once

#include <functional>

#include "diagnose/budget.h"
#include "diagnose/decision.h"
#include "diagnose/hypotheses.h"
#include "diagnose/rows.h"

namespace host::diagnosis {

struct Candidate {
  std::string name;
  TermGroup columns;
  std::vector<double> size;               ///< plausible magnitude of each parameter
  double share = share_of(Kind::effect);  ///< of the recording's error level
  Kind kind = Kind::effect;
  std::vector<TermGroup> beside = {};  ///< what it must show beside, to be told from it
};

/// Is p, of one look, below what a hypothesis of this share has of the recording's error level?
bool called(double log10_p, double share);

/// One segment by itself, over the same columns.
struct Piece {
  Rows rows;
  double start_s = 0, end_s = 0;
  bool held_out = false;
};

/// Both halves see the whole time: segments 0, 3, 4, 7, 8, ... against the rest.
inline bool is_held_out(std::size_t segment) { return (segment + 1) / 2 % 2 == 1; }

/// Entries of theta that a shock moves together.
struct Block {
  std::string name;
  TermGroup columns;         ///< counted from theta's first
  std::vector<double> size;  ///< plausible step
};

/// The rows of a recording, linearised at one fit. `train` and
/// `held_out` are interleaved halves of it, joined in themselves.
struct Problem {
  int n_theta = 0;
  Prior prior;
  Rows all, train, held_out;  ///< without the prior
  double noise = 1;           ///< variance of whitened residuals that is known to be noise; 1: as stated
  std::vector<Piece> pieces;  ///< in time order; empty: steps are not looked for
  std::vector<Block> blocks;
};

/// What the rows say about one candidate when theta and others are free.
struct EffectTest {
  int seen = 0;                  ///< directions that would have shown
  double statistic = 0;          ///< over the dispersion
  double chi2 = 0;               ///< the same not divided: what the cost falls by
  double log10_p = 0;            ///< not corrected
  Eigen::VectorXd value, sigma;  ///< sigma scaled by the dispersion's root
  double largest_gain = 0;       ///< plausible size over sigma in the direction seen best
  /// log of how much likelier the rows are with the effect than without, its value ~ N(0, size^2) in all directions.
  double log_evidence = 0;
};
EffectTest test_effect(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free);

/// By itself; nothing is seen where it would not show beside what it has to be told from.
EffectTest test_alone(const Problem& problem, const Candidate& candidate);

/// Do the halves agree, and does what one says help the other?
struct HalvesTest {
  double log10_p_disagree = 0;  ///< of |c_T - c_H|^2
  /// Fall of the held-out cost, summed over both ways, over the dispersion; plus what the training's uncertainty takes
  /// from it on average, so that its expectation is the whole excess, however many parameters the effect has.
  double gain = 0;
};
HalvesTest test_halves(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free);
/// Why the halves speak against it, in words; empty where both tell of the same value.
std::string halves_refuse(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free);

/// Where each piece has a value of its own, how much better is the fit?
struct Scatter {
  double factor = 1;  ///< a chi-square number over its degrees of freedom, at least 1
  int dof = 0;        ///< of which it was estimated; 0: fewer than four pieces
  /// An effect's statistic is judged against the scatter of its own value: real tracks and motions disagree with
  /// themselves by more than their noise, and from a few pieces that is only roughly known.
  double log10_p(double statistic, int seen) const;
};
Scatter scatter_over_time(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free);

/// test_effect, judged against the scatter of the effect's own value: statistic and sigma in units of it, p by F.
EffectTest judge_effect(const Problem& problem, const Candidate& candidate, const std::vector<TermGroup>& free);

/// chi2/dof of the model with these effects free, at least the known noise.
double dispersion(const Problem& problem, const std::vector<TermGroup>& free);

struct Accepted {
  int candidate = -1;
  EffectTest test;  ///< with the other accepted ones free
};
/// A step of one block of theta, found by a search over blocks and times.
struct Shift {
  Block block;
  double time_s = 0, uncertainty_s = 0;
  int trials = 0;       ///< blocks times instants that were compared
  int straddling = -1;  ///< piece in which it happens and that fits neither side: left out; -1: between two pieces
  EffectTest test;
};

/// The last refit's rows, each side of a step linearised at its own theta, which is expected this far from the fit's.
using AtStep = std::function<Problem(const Shift&, const Eigen::VectorXd& before, const Eigen::VectorXd& after)>;

struct SelectionOptions {
  std::vector<int> known = {};  ///< candidates that are in the model from the start and stay
  Budget* work = nullptr;       ///< null: as much as it takes
  AtStep at_step = {};          ///< empty: rows stay as they are
};

struct Rejected {
  int candidate = -1;
  std::string why;
};
/// B explains what A explains, and this motion does not say which it was.
struct Pair {
  int accepted = -1, other = -1;
};

/// What is called for beside everything that was accepted, and was refused.
struct Leftover {
  double chi2 = 0;   ///< the largest fall of the cost
  std::string what;  ///< name of that candidate
  void take(double fall, const std::string& name);
};

struct Selection {
  Problem problem;  ///< at the last fit
  std::vector<Accepted> accepted;
  std::vector<Rejected> rejected;
  std::vector<Pair> pairs;
  std::vector<int> cannot_tell;
  std::vector<Candidate> candidates;  ///< as given, and behind them calibration_shift where one was tried
  Leftover leftover;                  ///< of the candidates that are significant at the end and were refused
  bool shifted = false;
  Shift shift;                    ///< where `shifted`
  std::vector<EffectTest> alone;  ///< each candidate by itself, at the first fit
};

/// Of the catalogue's effects that are called for beside the accepted ones, judged against their own scatter.
Leftover leftover_of(const Selection& selection);

/// Fits with these candidates' effects free and linearises there.
using Refit = std::function<Problem(const std::vector<int>& accepted)>;

Selection select_effects(const std::vector<Candidate>& candidates, const SelectionOptions& options, const Refit& refit);

}  // namespace host::diagnosis
