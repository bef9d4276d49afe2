// Every number that the decision of `segcal diagnose` depends on, with its reason.
//
// The error level of a recording is shared out among all hypotheses beforehand, each share its prior probability
// (weighted Bonferroni: Holm, A simple sequentially rejective multiple test procedure, 1979, with weights): a
// hypothesis of share q is called where log10 p < log10 level + log10 q. The shares add up to less than one, so that
// with nothing there the probability of any name is below the level, however many hypotheses are asked; after a right
// name the same holds for the next one.
#pragma once

namespace host::diagnosis::decision {

// ---- Calling something

/// log10 of the probability that a recording without any effect gets a name, over all looks at it: no name is expected
/// in 200 recordings with probability 0.67 at 2e-3.
constexpr double kLog10Level = -2.7;
/// Shares of the level. Effects of the catalogue are what devices are known to do: nine tenths,
/// shared equally among its 12 entries that columns stand for. Shocks are rarer, and each block at
/// each instant is a hypothesis: a tenth over their number, less what a term of the dictionary has:
/// it has no physics behind it, a hundredth over the number of terms. Rounds of noise look again, but
/// a recording without any effect has none: a noise is asked for six of its sigmas (kNoiseSigmas).
/// Where a recording has exposures, exposure_offset is one entry more.
constexpr double kCatalogueShare = 0.9 / 12, kShareWithExposures = 0.9 / 13, kStepsShare = 0.09,
                 kDictionaryShare = 0.01;
/// Effects in one model; more are no diagnosis.
constexpr int kMostEffects = 5;

/// A direction has shown where its sigma is below a third of the plausible size: with a larger sigma an effect would
/// have to be beyond what is plausible to be called at all. Then the answer is "cannot tell".
constexpr double kSeen = 3;
/// Prior sigma of a value in plausible sizes, where a value must be finite in directions that were not seen.
constexpr double kWidePrior = 10;
/// The squares of a segment's sensors, added up, over those of its rows, relative to the lengths of the columns:
/// further apart than this, one of the two eliminations has lost a direction in rounding, and no gap is told for a
/// sensor. Sound ones are 1e-4 to 6e-4 apart, 0.012 at most (float, in segments that hardly move).
constexpr double kSensorsAddUp = 0.1;

// ---- Is it the same throughout?

/// log10 p below which the halves contradict each other: one right effect of a
/// thousand is lost. And the share of a value by which they may differ because they
/// are linearised far from it, before the fit that takes it in: not calibrated.
constexpr double kLog10Disagree = -3, kCurvature = 0.1;
/// Share of its statistic s by which a value must lower the other half's cost.
/// The whole of s is expected, with a spread of about 2 sqrt(s): at the smallest
/// s that is called, 16, half of it. A quarter is one and a half spreads below.
constexpr double kHelps = 0.25;

// ---- What else could it be?

/// Share, over the number of terms, of the level at which a term of the dictionary counts as left over. It takes a name
/// back and gives none, so that it has what a name has, and not kDictionaryShare.
constexpr double kLeftShare = 1;

/// How many times the statistic of every other effect one must have to be fitted before them, and to be tried where its
/// value is not the same throughout: far from its value the rows of everything are linearised at the wrong place. An
/// accelerometer whose bias moves by 1 m/s^2 showed 7 and 45 times as much as what else it looked like, and was
/// refused; what stays is asked all again at its own fit. Not calibrated.
constexpr double kDominates = 3;

/// Share of the statistic of all others that a step must have. A step fits whatever changes with time, also what the
/// linearisation of another effect leaves. Set after the study `hidden`, seed 3, in which a hysteresis was named
/// gyro_lag and a step; not calibrated.
constexpr double kStepOfOthers = 0.05;
/// Share of the held-out excess that all effects together must remove for a name. The best wrong effect removes less:
/// gyro_lag of a hysteresis 83 % (up to 98 % where it is large, which kMostRest refuses).
constexpr double kNamesFrom = 0.9;
/// Share of the folds that must choose an effect themselves, or what it makes a pair with: half. Of 31 right names 29
/// were chosen by three of four and more, a step of r_CI by one; gyro_lag in the place of a two-way shutter by one.
constexpr double kFoldsConfirm = 0.5;
/// Share of the excess that something else may clearly follow, for a name of the
/// catalogue. Right effects leave up to 3e-3 (46 simulated recordings none, euroc_mh01
/// with shifted stamps 3e-3), gyro_lag in the place of a hysteresis 1.5 to 3 %.
constexpr double kMostRest = 0.01;
/// log10 p, over all tests, of residuals that follow an effect's own cause with it
/// in the model: one right name of a hundred is lost to chance. Beside the right
/// effect p was above 0.1, beside gyro_lag in the place of a hysteresis 3e-3.
constexpr double kLog10StructureLeft = -2;
/// Two effects are a pair where, with one in the model, the other adds nothing at one in a hundred, and the fits with
/// either differ by less than 6 in chi2, likelihoods of 20 : 1.
constexpr double kLog10AddsNothing = -2, kFitsAlike = 6;

// ---- The gap

/// Sigmas within which an excess that is left counts as none, and from which on chi2 over the noise floor is something:
/// one of 20 and one of 30,000 by chance.
constexpr double kCountsAsNone = 2, kOverFloor = 4;
/// Sigmas of it that chance leaves once in a thousand right effects, as it parts the halves (kLog10Disagree):
/// chi-square of one degree of freedom is 10.8 there, and has a mean of 1 and a variance of 2.
constexpr double kChanceLeaves = 7;

// ---- Steps

/// Sigmas of a piece's own chi2 from which on it belongs neither before nor after, and log10 p of a step from which on
/// that is asked: with a hundred trials a less significant one is not called in any case.
constexpr double kFitsNeither = 8, kLog10LookInside = -6;
/// log10 p of the scatter of a step over its pieces from which on the step is judged against it. They are often few,
/// and F of few degrees would cost most steps.
constexpr double kLog10Scatters = -2;

// ---- Stamps that follow the exposure

/// Sigmas that kappa may still move by at a fit whose stamps were moved by it, and how often the fit is made again for
/// that. Terms of the dictionary are asked about with stamps as they are: where kappa was let go within 0.02, 2 % of a
/// gap followed the change of the rate, which cost a right name (arvr, seed 3, kappa 0.1).
constexpr double kKappaSettles = 0.3;
constexpr int kKappaRounds = 3;

// ---- Noise

/// A pixel noise above the stated one by less changes sigmas by as little; and by how many of its own sigmas it must
/// differ, as the residuals that it is a mean of are not independent: not calibrated.
constexpr double kNoiseAbove = 0.04, kNoiseSigmas = 6;
/// Far-off points leave a fit whose noise is stated too small, so that the first factor is too small too.
constexpr int kNoiseRounds = 3;

/// Walk along a track, per square root of a second, over the white noise, from which on tracks drift: after half a
/// second, the time between two keyframes, the drift has the variance of the white noise. Simulated white tracks show
/// 0.04, and 0.9 with a missing time offset of 1 ms; euroc_mh01 13.
constexpr double kWalkOfWhite = 1.4;
/// Share of the points' squares that differences of neighbours must hold for that: all of it (1.1 to 1.2, since a fit
/// takes its share of the squares) where tracks drift each by itself, 0.9 on euroc_mh01, 0.2 to 0.4 where hysteresis or
/// an error of the attitude moves neighbours alike.
constexpr double kOwnSquares = 2.0 / 3;

// ---- Time

/// Work of one diagnosis in slices of the core: rounds of noise, effects and terms draw on it together. A million take
/// 6 to 8 s of the minute that a diagnosis may take, with the rows that are linearised besides and the filter's starts.
/// No fit begins that less is left for than the last one took; one that does not settle, and is made again with larger
/// noise, has exceeded it by 2 million all the same. A recording that lacks nothing or one effect needs 0.3 to 1
/// million.
constexpr int kSlices = 4000000;
/// Of a second look with what rotation tells, where the first used its work up: what a recording with one effect needs.
constexpr int kSlicesAgain = 1500000;
/// Rounds of terms beyond the catalogue, and how many terms of one are asked in parts.
constexpr int kTermRounds = 3, kTermsAsked = 8;

}  // namespace host::diagnosis::decision
