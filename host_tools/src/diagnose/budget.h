// How much work a diagnosis may still do. Selection, rounds of noise and terms beyond the catalogue draw on one budget,
// so that no recording takes much longer than others; an answer that it cut short says so. Work is counted in slices of
// the core (segcal_progress), each bounded, and not in fits or seconds: a fit that does not settle takes ten times as
// long as one that does, and an answer must not depend on the machine.
#pragma once

#include <cstdint>

namespace host::diagnosis {

class Budget {
 public:
  /// `must_answer`: the first fit is made whatever it costs; else a fit that uses all up ends the diagnosis without a
  /// verdict, which a second look may.
  explicit Budget(std::int64_t slices, bool must_answer = true) : left_(slices), must_answer_(must_answer) {}
  /// May another fit be made? Not where less is left than the last one took: a model that lacks something makes them
  /// longer, by up to ten times, and what a fit begins is done to its end.
  bool allows_fit() { return allows(last_); }
  /// May something be begun that takes about as much as this? Remembers that it was asked in vain.
  bool allows(std::int64_t slices) {
    used_up_ = used_up_ || left_ < slices;
    return left_ >= slices;
  }
  /// What a fit took.
  void take(std::int64_t slices) {
    left_ -= slices;
    last_ = slices;
  }
  /// What was done beside fits.
  void spend(std::int64_t slices) { left_ -= slices; }
  std::int64_t left() const { return left_; }
  bool used_up() const { return used_up_; }
  bool must_answer() const { return must_answer_; }

 private:
  std::int64_t left_, last_ = 1;
  bool must_answer_, used_up_ = false;
};

}  // namespace host::diagnosis
