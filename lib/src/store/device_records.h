// A device as records: what a save reads, and who takes what a restore finds.
#pragma once

#include "api/handle.h"
#include "store/ring.h"
#include "store/stored_fields.h"

namespace SEGCAL_NS {

enum class RecordType : std::uint16_t {
  identity = 1,
  numbers = 2,
  results = 3,
  segment = 4,
  memory = 5,
  epoch = 7,
  changes = 8,
  history = 9,
  session = 10
};
/// An epoch in format 1.1, which measured scatter otherwise: passed over.
constexpr std::uint16_t kOldEpoch = 6;

class DeviceRecords {
 public:
  using Stored = StoredFields<Real>;

  /// While the work lasts.
  void attach(CDevice* device) {
    device_ = &device->device;
    difference_ = nullptr;
  }
  void detach() { device_ = nullptr; }
  /// The device as created, after a restore that found nothing it may use.
  void leave_empty() { Stored::begin(device_); }
  bool attached() const { return device_ != nullptr; }
  const char* difference() const { return difference_; }

  RecordSource source();
  RecordSink sink();

 private:
  static constexpr std::uint32_t kFirstSegment = 3;  ///< records before it
  /// Records behind the segments: what is remembered of others, changes, each epoch, the history, each session.
  std::uint32_t memories() const {
    if (kEpochs == 0) return 0;
    const int sessions = device_->history().count();
    return static_cast<std::uint32_t>(2 + device_->epochs().count() + (kHistory > 0 ? 1 + sessions : 0));
  }
  static DeviceRecords& self(void* context) { return *static_cast<DeviceRecords*>(context); }
  int nth_kept(std::uint32_t n) const;
  RecordInfo info(std::uint32_t number) const;
  void visit(const RecordInfo& record, Fields* fields);
  std::uint32_t size(const RecordInfo& record) {
    Fields measure;
    visit(record, &measure);
    return measure.size();
  }
  bool expected(const RecordInfo& record) const;
  int take(std::uint32_t offset, const std::uint8_t* bytes, std::uint32_t n);
  int close();

  Device<Real>* device_ = nullptr;
  StoredNumbers<Real> numbers_;
  std::uint64_t revision_ = 0;
  RecordInfo record_{};
  std::uint32_t taken_ = 0;    ///< records
  std::int32_t sessions_ = 0;  ///< among them
  bool skips_ = false, sound_ = true;
  std::int32_t error_ = SEGCAL_OK;  ///< what difference_ means
  const char* difference_ = nullptr;
};

}  // namespace SEGCAL_NS
