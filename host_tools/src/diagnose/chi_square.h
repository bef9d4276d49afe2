// Tail probabilities in log10, so that a statistic of a million is still a number.
#pragma once

namespace host::diagnosis {

/// log10 of the probability that a chi-square number with `dof` degrees of freedom exceeds `s`; 0 for dof 0 or s <= 0.
double log10_upper_tail(double s, int dof);

/// The statistic that is exceeded with probability 10^log10_p.
double upper_quantile(double log10_p, int dof);

/// The same for Fisher's F: a chi-square number over its m degrees of freedom, over a variance that was itself
/// estimated from n. With few n its tail is much longer: at n = 4, m = 1 a ratio of 60 has p = 1.5e-3, not 1e-14.
double log10_upper_tail_of_ratio(double ratio, int m, int n);

}  // namespace host::diagnosis
