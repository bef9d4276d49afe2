// Functions that work in slices: each call goes on where the last one paused and returns true when all is done.
//
//   bool sum_all() {
//     SEGCAL_SLICES(place_) {
//       for (i_ = 0; i_ < n_; ++i_) {
//         sum_ += expensive(i_);
//         SEGCAL_PAUSE(place_);
//       }
//       SEGCAL_AWAIT(place_, another_such_function());
//     }
//     SEGCAL_SLICES_END(place_);
//   }
//
// The place is a line number inside a switch (protothreads; Dunkels et al. 2006), so there is no second stack. What
// must live across a pause is a member; a local variable may stand before SEGCAL_SLICES, where each call makes it anew,
// or in a block without a pause. After the end the place is at the start again. One pause or await per line.
#pragma once

#include <cstdint>

#include "segcal/config.h"

namespace SEGCAL_NS {
using Place = std::int32_t;
}

#define SEGCAL_SLICES(place) \
  switch (place)             \
  case 0:

#define SEGCAL_PAUSE(place) \
  do {                      \
    place = __LINE__;       \
    return false;           \
    case __LINE__:;         \
  } while (0)

/// Pauses wherever `step` does.
#define SEGCAL_AWAIT(place, step) \
  do {                            \
    place = __LINE__;             \
    [[fallthrough]];              \
    case __LINE__:                \
      if (!(step)) return false;  \
  } while (0)

#define SEGCAL_SLICES_END(place) \
  place = 0;                     \
  return true
