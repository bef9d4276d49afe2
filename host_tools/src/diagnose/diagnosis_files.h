// The texts of a diagnosis.
#pragma once

#include "diagnose/diagnose.h"

namespace host {

std::string effects_header(const Diagnosis& diagnosis);
std::string diagnosis_data_json(const Diagnosis& diagnosis, const std::vector<Recording>& sessions);

}  // namespace host
