// The small numbers of a device that outlive power (docs/storage.md, "Records").
#pragma once

#include "api/device.h"
#include "store/fields.h"

namespace SEGCAL_NS {

/// A save takes them at its beginning, since the device may be fed while it goes on.
template <class S>
struct StoredNumbers {
  FaultCounts faults;
  BuilderCounts left_out;
  std::uint64_t trajectory, random, offered;
  std::int64_t frame_period;
  double builder_origin[3];
  std::uint32_t session, serial, frame;
  std::int32_t building;
  S warmth;
  bool knew_enough, own_odometry, calibrated;
  bool session_open;  ///< the session had samples or frames

  static_assert(sizeof(FaultCounts) % 4 == 0 && sizeof(BuilderCounts) % 4 == 0, "stored as arrays of numbers");

  void fields(Fields* f) {
    f->records(&faults, 1, sizeof faults);
    f->records(&left_out, 1, sizeof left_out);
    for (std::uint64_t* v : {&trajectory, &random, &offered}) f->number(v);
    f->number(&frame_period);
    f->array(builder_origin, 3);
    for (std::uint32_t* v : {&session, &serial, &frame}) f->number(v);
    f->count(&building, Database<S>::kSlots - 1);
    f->number(&warmth);
    for (bool* v : {&knew_enough, &own_odometry, &calibrated, &session_open}) f->flag(v);
  }
};

}  // namespace SEGCAL_NS
