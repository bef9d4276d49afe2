// How many fits a diagnosis may still make. Selection, rounds of noise and terms beyond the catalogue draw on one
// budget, so that no recording takes much longer than others; an answer that it cut short says so.
#pragma once

namespace host::diagnosis {

class Budget {
 public:
  explicit Budget(int fits) : left_(fits) {}
  /// May another fit be made? Remembers that it was asked in vain.
  bool allows() {
    used_up_ = used_up_ || left_ <= 0;
    return left_ > 0;
  }
  void take() { --left_; }
  bool used_up() const { return used_up_; }

 private:
  int left_;
  bool used_up_ = false;
};

}  // namespace host::diagnosis
