// Names and units of terms, for people and files: "time_offset.t_d", "gyro_x:fy*wz", "image_u:x^2*y".
#pragma once

#include "sensors/effect_catalogue.h"

namespace SEGCAL_NS {

constexpr const char* kTermAxes[6] = {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"};
constexpr const char* kSignalNames[kNamedSignals] = {"1",    "wx",  "wy", "wz", "|wx|",    "|wy|",
                                                     "|wz|", "|w|", "fx", "fy", "fz",      "dwx",
                                                     "dwy",  "dwz", "T",  "t",  "cos_yaw", "sin_yaw"};
/// Powers of rad, m, s and degC in a signal's unit.
struct Dimension {
  int rad, m, s, degC;
};
constexpr Dimension kDimension[kNamedSignals] = {
    {0, 0, 0, 0},  {1, 0, -1, 0}, {1, 0, -1, 0}, {1, 0, -1, 0}, {1, 0, -1, 0}, {1, 0, -1, 0},
    {1, 0, -1, 0}, {1, 0, -1, 0}, {0, 1, -2, 0}, {0, 1, -2, 0}, {0, 1, -2, 0}, {1, 0, -2, 0},
    {1, 0, -2, 0}, {1, 0, -2, 0}, {0, 0, 0, 1},  {0, 0, 1, 0},  {0, 0, 0, 0},  {0, 0, 0, 0}};

/// Text into memory of a fixed size; what does not fit is cut off.
class TextWriter {
 public:
  TextWriter(char* out, int size) : out_(out), left_(size - 1) { *out_ = 0; }
  TextWriter& text(const char* s) {
    for (; *s && left_ > 0; ++s, --left_) *out_++ = *s;
    *out_ = 0;
    return *this;
  }
  TextWriter& number(int n) {
    const char digit[2] = {static_cast<char>('0' + n), 0};
    return text(digit);
  }

 private:
  char* out_;
  int left_;
};

/// "rad^2 s^-1" and the like: at most four factors.
inline void write_unit(const Dimension& d, TextWriter* out) {
  const char* const name[4] = {"rad", "m", "s", "degC"};
  const int power[4] = {d.rad, d.m, d.s, d.degC};
  bool first = true;
  for (int i = 0; i < 4; ++i) {
    if (power[i] == 0) continue;
    if (!first) out->text(" ");
    first = false;
    out->text(name[i]);
    if (power[i] == 1) continue;
    out->text(power[i] < 0 ? "^-" : "^").number(power[i] < 0 ? -power[i] : power[i]);
  }
  if (first) out->text("-");
}

[[gnu::cold]] inline void describe_product(const Term& t, TextWriter* name, TextWriter* unit) {
  name->text(kTermAxes[int(t.kind)]).text(":").text(kSignalNames[t.a]);
  if (t.b > 0) name->text("*").text(kSignalNames[t.b]);
  const Dimension a = kDimension[t.a], b = kDimension[t.b];
  const bool gyro = t.of_gyro();
  write_unit(
      {(gyro ? 1 : 0) - a.rad - b.rad, (gyro ? 0 : 1) - a.m - b.m, (gyro ? -1 : -2) - a.s - b.s, -a.degC - b.degC},
      unit);
}

inline void describe_powers(const Term& t, TextWriter* name, TextWriter* unit) {
  name->text(t.kind == TermKind::image_u ? "image_u:" : "image_v:");
  const char* const factor[3] = {"x", "y", "row"};
  const int power[3] = {t.a, t.b, t.c};
  bool first = true;
  for (int i = 0; i < 3; ++i) {
    if (power[i] == 0) continue;
    if (!first) name->text("*");
    first = false;
    name->text(factor[i]);
    if (power[i] > 1) name->text("^").number(power[i]);
  }
  if (first) name->text("1");
  unit->text("-");
}

/// Writes name and unit, cut off where they do not fit.
inline void write_term_name(const Term& term, char* name_out, int name_size, char* unit_out, int unit_size) {
  TextWriter name(name_out, name_size), unit(unit_out, unit_size);
  int effect, parameter;
  if (find_effect(term, &effect, &parameter)) {
    name.text(effect_entry(effect).name).text(".").text(effect_entry(effect).parameter[parameter]);
    unit.text(effect_entry(effect).unit);
  } else if (term.of_image()) {
    describe_powers(term, &name, &unit);
  } else {
    describe_product(term, &name, &unit);
  }
}

}  // namespace SEGCAL_NS
