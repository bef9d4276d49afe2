// segcal_effects.h: turns the effects on in a firmware build, through the configuration of the C API.
#include <cctype>
#include <cstdio>
#include <sstream>

#include "diagnose/diagnosis_files.h"
#include "diagnose/exposure_offset.h"

namespace host {
namespace {

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

void write_terms(const std::vector<ModelTerm>& model, std::ostringstream& out) {
  std::string bits, last;
  int further = 0;
  for (const ModelTerm& t : model) {
    if (t.effect.empty()) ++further;
    if (t.effect.empty() || t.effect == last) continue;
    last = t.effect;
    bits += (bits.empty() ? "" : " | ") + ("SEGCAL_EFFECT_" + upper(t.effect));
  }
  if (!bits.empty()) out << "  config->estimate_effects = " << bits << ";\n";
  if (further > 0) out << "  config->n_terms = " << further << ";\n";
  int place = 0, own = 0;
  for (const ModelTerm& t : model) {
    if (t.effect.empty()) {
      out << "  config->term[" << own << "].kind = " << t.term.kind << "; config->term[" << own << "].a = " << t.term.a
          << "; config->term[" << own << "].b = " << t.term.b << "; config->term[" << own << "].c = " << t.term.c
          << ";\n";
      ++own;
    }
    out << "  config->term_value[" << place++ << "] = " << number(t.parameter.value) << "; /* " << t.parameter.name
        << ", " << t.parameter.unit << ", +- " << number(t.parameter.sigma) << " */\n";
  }
}

/// Without what the core has no effect for.
std::vector<ModelTerm> of_core(const std::vector<ModelTerm>& model) {
  std::vector<ModelTerm> out;
  for (const ModelTerm& t : model)
    if (t.effect != diagnosis::kExposureOffset) out.push_back(t);
  return out;
}

/// That is done where images are pushed.
void write_kappa(const Diagnosis& d, std::ostringstream& out) {
  for (const ModelTerm& t : d.model) {
    if (t.effect != diagnosis::kExposureOffset) continue;
    out << "/* Push each image at its stamp plus this times its exposure; +- " << number(t.parameter.sigma)
        << ". */\n#define SEGCAL_STAMP_EXPOSURE " << number(t.parameter.value) << "\n\n";
  }
}

}  // namespace

std::string effects_header(const Diagnosis& d) {
  std::ostringstream out;
  out << "/* What `segcal diagnose` found in a recording of this device. Call segcal_set_effects() on the "
         "configuration before\n"
      << "   segcal_create(): the effects start at these values and are estimated from then on. */\n"
      << "#ifndef SEGCAL_EFFECTS_H\n#define SEGCAL_EFFECTS_H\n\n#include \"segcal/segcal.h\"\n\n";
  const std::vector<ModelTerm> model = of_core(d.model);
  write_kappa(d, out);
  int terms = 0;
  for (const ModelTerm& t : model) terms += t.parameter.name.empty() ? 0 : 1;
  out << "#if SEGCAL_MAX_EFFECT_ESTIMATES < " << terms
      << "\n#error \"build segcal with SEGCAL_MAX_EFFECT_ESTIMATES of at least " << terms << "\"\n#endif\n\n";
  out << "static inline void segcal_set_effects(segcal_config_t *config) {\n";
  write_terms(model, out);
  out << "  config->gyro_noise_density = " << number(d.noise.gyro_noise_density) << ";   /* rad/s/sqrt(Hz) */\n"
      << "  config->accel_noise_density = " << number(d.noise.accel_noise_density) << ";  /* m/s^2/sqrt(Hz) */\n"
      << "  config->pixel_sigma = " << number(d.pixel_sigma) << ";          /* px */\n"
      << "}\n\n#endif\n";
  return out.str();
}

}  // namespace host
