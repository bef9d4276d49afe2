// From tests to an answer: named effects with their values, the verdict, and sentences.
#pragma once

#include "diagnose/diagnose.h"
#include "diagnose/evidence.h"

namespace host::diagnosis {

/// "3.0 ms +- 0.1": a value with a prefix for people and as many digits as its sigma deserves.
std::string in_words(double value, double sigma, const std::string& unit);

/// "gyro x error follows accel y times rate z".
std::string in_words(const CoreTerm& term);

/// An accepted candidate with its parameters and a sentence.
DiagnosedEffect named(const Candidate& candidate, const Accepted& accepted, const std::vector<TermInfo>& terms);
DiagnosedEffect named(const Shift& shift, const Accepted& accepted);
/// A variance component; `sensor`: gyro_noise, accel_noise or pixel_noise.
DiagnosedEffect named_noise(const std::string& effect, const std::vector<DiagnosedParameter>& factors);

/// Verdict and sentence from everything else.
void conclude(Diagnosis* diagnosis);

}  // namespace host::diagnosis
