#include "store/device_records.h"

namespace SEGCAL_NS {

/// Slot of the nth kept segment.
int DeviceRecords::nth_kept(std::uint32_t n) const {
  int slot = -1;
  for (std::uint32_t left = n + 1; left > 0; --left) {
    do {
      ++slot;
    } while (!device_->database().kept(slot));
  }
  return slot;
}

RecordInfo DeviceRecords::info(std::uint32_t number) const {
  RecordInfo record{};
  const std::uint32_t first_memory = kFirstSegment + static_cast<std::uint32_t>(device_->database().size());
  if (number >= first_memory) {
    const std::uint32_t i = number - first_memory, epochs = static_cast<std::uint32_t>(device_->epochs().count());
    const RecordType type = i == 0            ? RecordType::memory
                            : i == 1          ? RecordType::changes
                            : i < 2 + epochs  ? RecordType::epoch
                            : i == 2 + epochs ? RecordType::history
                                              : RecordType::session;
    record.type = static_cast<std::uint16_t>(type);
    record.index = static_cast<std::uint16_t>(type == RecordType::epoch     ? i - 2
                                              : type == RecordType::session ? i - 3 - epochs
                                                                            : 0);
    return record;
  }
  record.type = static_cast<std::uint16_t>(number < kFirstSegment ? number + 1 : std::uint32_t(RecordType::segment));
  if (number >= kFirstSegment) record.index = static_cast<std::uint16_t>(nth_kept(number - kFirstSegment));
  return record;
}

void DeviceRecords::visit(const RecordInfo& record, Fields* fields) {
  switch (static_cast<RecordType>(record.type)) {
    case RecordType::identity: return StoredOptions<Real>::identity(fields, Stored::options(device_));
    case RecordType::numbers: return numbers_.fields(fields);
    case RecordType::results: return Stored::results(fields, device_);
    case RecordType::memory: return Stored::memory(fields, device_);
    case RecordType::changes: return Stored::changes(fields, device_);
    case RecordType::epoch: return Stored::epoch(fields, device_, record.index);
    case RecordType::history: return Stored::history(fields, device_);
    case RecordType::session: return Stored::session(fields, device_, record.index);
    default: return Stored::segment(fields, Stored::slot(device_, record.index));
  }
}

RecordSource DeviceRecords::source() {
  numbers_ = Stored::take_numbers(*device_);
  revision_ = Stored::revision(*device_);
  RecordSource source;
  source.context = this;
  source.count = kFirstSegment + static_cast<std::uint32_t>(device_->database().size()) + memories();
  source.info = [](void* context, std::uint32_t number) {
    RecordInfo record = self(context).info(number);
    record.bytes = self(context).size(record);
    return record;
  };
  source.read = [](void* context, std::uint32_t number, std::uint32_t offset, std::uint8_t* to, std::uint32_t n) {
    Fields fields(offset, to, n);
    self(context).visit(self(context).info(number), &fields);
  };
  source.unchanged = [](void* context) {
    const DeviceRecords& r = self(context);
    return Stored::at_rest(*r.device_) && Stored::revision(*r.device_) == r.revision_;
  };
  return source;
}

/// The first three records in their order, then segments, then epochs; what a newer minor format adds is passed over.
bool DeviceRecords::expected(const RecordInfo& record) const {
  if (taken_ < kFirstSegment) return record.type == taken_ + 1;
  if (record.type == std::uint16_t(RecordType::epoch) && kEpochs > 0) {
    return record.index == device_->epochs().count() && record.index < kEpochs;
  }
  if (record.type == std::uint16_t(RecordType::session) && kHistory > 0)
    return record.index == sessions_ && sessions_ < device_->history().count();
  return record.type != std::uint16_t(RecordType::segment) ||
         (record.index < Database<Real>::kSlots && !device_->database().kept(record.index));
}

RecordSink DeviceRecords::sink() {
  RecordSink sink;
  sink.context = this;
  sink.begin = [](void* context) {
    DeviceRecords& r = self(context);
    Stored::begin(r.device_);
    r.numbers_ = StoredNumbers<Real>{};
    r.taken_ = 0;
    r.sessions_ = 0;
    r.difference_ = nullptr;
  };
  sink.record = [](void* context, const RecordInfo& record) -> int {
    DeviceRecords& r = self(context);
    r.record_ = record;
    r.sound_ = true;
    constexpr RecordType kLast = kHistory > 0  ? RecordType::session
                                 : kEpochs > 0 ? RecordType::changes
                                               : RecordType::segment;
    r.skips_ = record.type > std::uint16_t(kLast) || record.type == kOldEpoch || record.type == 0;
    if (!r.expected(record)) return RecordSink::kNotThis;
    if (record.type == std::uint16_t(RecordType::epoch)) Stored::begin_epoch(r.device_, record.index);
    if (record.type == std::uint16_t(RecordType::session)) Stored::begin_session(r.device_, record.index);
    return SEGCAL_OK;
  };
  sink.bytes = [](void* context, std::uint32_t offset, const std::uint8_t* bytes, std::uint32_t n) {
    return self(context).take(offset, bytes, n);
  };
  sink.close = [](void* context) { return self(context).close(); };
  sink.end = [](void* context) {
    DeviceRecords& r = self(context);
    return r.taken_ >= kFirstSegment && r.sessions_ == r.device_->history().count() &&
                   Stored::install(r.numbers_, r.device_)
               ? SEGCAL_OK
               : RecordSink::kNotThis;
  };
  return sink;
}

int DeviceRecords::take(std::uint32_t offset, const std::uint8_t* bytes, std::uint32_t n) {
  if (skips_) return SEGCAL_OK;
  const bool compares = record_.type == std::uint16_t(RecordType::identity);
  Fields fields(compares ? Fields::Does::compares : Fields::Does::writes, offset, bytes, n);
  visit(record_, &fields);
  if (compares && fields.difference() && !difference_) {
    difference_ = fields.difference();
    error_ = fields.error();
  }
  sound_ = sound_ && (compares || fields.valid());
  return SEGCAL_OK;
}

/// The record is as it was written; whether it fits this device.
int DeviceRecords::close() {
  ++taken_;
  if (skips_) return SEGCAL_OK;
  if (record_.type == std::uint16_t(RecordType::identity)) {
    if (difference_) return error_;
    if (record_.bytes == size(record_)) return SEGCAL_OK;
    difference_ = "number of the configuration's fields";
    return SEGCAL_ERROR_CONFIG;
  }
  if (!sound_ || record_.bytes != size(record_)) return RecordSink::kNotThis;
  if (record_.type == std::uint16_t(RecordType::epoch))
    return Stored::keep_epoch(device_, record_.index) ? SEGCAL_OK : RecordSink::kNotThis;
  if (record_.type == std::uint16_t(RecordType::session))
    return Stored::keep_session(device_, sessions_++) ? SEGCAL_OK : RecordSink::kNotThis;
  if (record_.type != std::uint16_t(RecordType::segment)) return SEGCAL_OK;
  if (!Stored::sound(*Stored::slot(device_, record_.index), device_->theta())) return RecordSink::kNotThis;
  Stored::keep(device_, record_.index);
  return SEGCAL_OK;
}

}  // namespace SEGCAL_NS
