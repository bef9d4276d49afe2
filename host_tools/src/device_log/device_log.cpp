#include "device_log/device_log.h"

#include <fstream>

#include "csv.h"
#include "device_log/logged_config.h"
#include "log/config_fields.h"
#include "state/flash_image.h"

namespace host {
namespace {

namespace fs = std::filesystem;
using namespace SEGCAL_NS;

static_assert(FlashImage::kProgramBytes == kStateProgramBytes && FlashImage::kEraseBytes == kStateEraseBytes,
              "a logged state is put into such flash page by page");

std::vector<std::uint8_t> bytes_of(const fs::path& file) {
  expect_regular_file(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": expected a device log, but the file cannot be read");
  return std::vector<std::uint8_t>((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
}

[[noreturn]] void fail(const fs::path& name, std::size_t offset, const std::string& found) {
  throw InputError(name.string() + ": byte " + std::to_string(offset) + ": " + found);
}

/// Blocks into sessions, in the order of the log.
class Decoder {
 public:
  Decoder(const fs::path& name, const LogBlocks& blocks) : name_(name), blocks_(blocks) {}

  DeviceLog run() {
    for (const LogBlockView& block : blocks_.blocks) take(block);
    if (!has_config_) fail(name_, 0, "expected a header and a configuration first, found none");
    for (std::size_t i = 0; i + 1 < out_.sessions.size(); ++i) out_.sessions[i].device->last = false;
    return std::move(out_);
  }

 private:
  void take(const LogBlockView& block) {
    const bool first = block.type <= static_cast<std::uint16_t>(LogBlock::config);
    if (!first && !has_config_)
      fail(name_, block.offset,
           "expected a header and a configuration first, found a block of type " + std::to_string(block.type));
    ByteReader in(block.payload, block.size);
    switch (static_cast<LogBlock>(block.type)) {
      case LogBlock::header: take_header(block, &in); break;
      case LogBlock::config: take_config(block); return;
      case LogBlock::imu: take_samples(block, &in); break;
      case LogBlock::tracks: take_frame(block, &in); break;
      case LogBlock::mark: take_mark(block, in.integer<std::int32_t>()); break;
      case LogBlock::hash: session().device->calls.push_back({DeviceCall::hash, in.integer<std::uint64_t>()}); break;
      case LogBlock::end: break;
      case LogBlock::state: take_state(block, &in); break;
      default:
        fail(name_, block.offset,
             "expected a block type from 0 to 7, found " + std::to_string(block.type) + ", of a newer segcal");
    }
    if (!in.complete() || in.left() > 0) {
      fail(name_, block.offset,
           "expected another number of bytes in a block of type " + std::to_string(block.type) + ", found " +
               std::to_string(block.size));
    }
  }

  void take_header(const LogBlockView& block, ByteReader* in) {
    const std::uint32_t format = in->integer<std::uint32_t>();
    if (format != SEGCAL_LOG_FORMAT) {
      fail(name_, block.offset,
           "expected log format " + std::to_string(SEGCAL_LOG_FORMAT) + ", found " + std::to_string(format));
    }
    in->integer<std::uint32_t>();  // version of the library
    const int n =
        in->left() == kFewestLoggedCapacities * sizeof(std::uint32_t) ? kFewestLoggedCapacities : kLoggedCapacities;
    std::uint32_t capacities[kLoggedCapacities];
    for (int i = 0; i < n; ++i) capacities[i] = in->integer<std::uint32_t>();
    profile_ = profile_of(capacities, n);
  }

  void take_config(const LogBlockView& block) {
    if (has_config_) fail(name_, block.offset, "expected one configuration, found a second one");
    segcal_config_t config;
    if (!read_config(block.payload, block.size, &config)) {
      fail(name_, block.offset,
           "expected a configuration of at most " + std::to_string(SEGCAL_MAX_CAMERAS) +
               " cameras, found another one or a newer one");
    }
    has_config_ = true;
    has_temperature_ = config.has_temperature != 0;
    config_.assign(block.payload, block.payload + block.size);
    out_.calibration = calibration_of(config);
    out_.noise = noise_of(config);
    if (config.pixel_sigma > 0) out_.pixel_sigma = config.pixel_sigma;
    begin_session();
  }

  /// A page of the device's flash. With holes it is no state, and who wants data only does not need it.
  void take_state(const LogBlockView& block, ByteReader* in) {
    const std::uint32_t at_block = in->integer<std::uint32_t>(), offset = in->integer<std::uint32_t>();
    const std::size_t page = in->left();
    const std::uint8_t* from = block.payload + block.size - page;
    while (in->left() > 0) in->integer<std::uint8_t>();
    if (!blocks_.damage.empty()) {
      out_.left_state_out = true;
      return;
    }
    FlashImage flash;
    flash.bytes.swap(session().device->state);  // and back: a copy for each page would take seconds
    const bool first = out_.sessions.size() == 1 && session().device->calls.empty();
    const bool fits = first && flash.append(at_block, offset, {reinterpret_cast<const char*>(from), page}, &last_page_);
    flash.bytes.swap(session().device->state);
    if (fits) return;
    fail(name_, block.offset,
         "expected the device's state before all else and page by page, found block " + std::to_string(at_block) +
             ", offset " + std::to_string(offset) + (first ? "" : " behind what it was fed"));
  }

  void take_samples(const LogBlockView& block, ByteReader* in) {
    const std::int64_t t0 = in->integer<std::int64_t>();
    const std::uint32_t n = in->integer<std::uint32_t>();
    if (in->left() != n * kImuSample)
      fail(name_, block.offset,
           "expected " + std::to_string(n) + " samples, found " + std::to_string(in->left()) + " bytes");
    for (std::uint32_t i = 0; i < n; ++i) {
      ImuSample sample;
      sample.t_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(t0) +
                                              static_cast<std::uint64_t>(std::int64_t{in->integer<std::int32_t>()}));
      for (double& value : sample.gyro) value = in->number32();
      for (double& value : sample.accel) value = in->number32();
      sample.temperature_degC = in->number32();
      session().imu.samples.push_back(sample);
      session().device->calls.push_back({DeviceCall::sample, 0});
    }
  }

  void take_frame(const LogBlockView& block, ByteReader* in) {
    const std::int64_t t_ns = in->integer<std::int64_t>();
    const std::uint32_t n = in->integer<std::uint32_t>();
    if (in->left() != n * kTrackPoint)
      fail(name_, block.offset,
           "expected " + std::to_string(n) + " points, found " + std::to_string(in->left()) + " bytes");
    for (CameraData& camera : session().cameras) camera.frames.push_back({t_ns, {}});
    for (std::uint32_t i = 0; i < n; ++i) {
      TrackPoint point;
      point.track_id = in->integer<std::uint32_t>();
      const std::size_t camera = in->integer<std::uint8_t>();
      point.u = in->number32();
      point.v = in->number32();
      if (camera >= session().cameras.size()) {
        fail(name_, block.offset,
             "expected cameras below " + std::to_string(session().cameras.size()) + ", found a point of camera " +
                 std::to_string(camera));
      }
      session().cameras[camera].frames.back().points.push_back(point);
    }
    session().device->calls.push_back({DeviceCall::frame, 0});
  }

  void take_mark(const LogBlockView& block, std::int32_t mark) {
    switch (mark) {
      case SEGCAL_LOG_NEW_SESSION: return begin_session();
      case SEGCAL_LOG_FLUSH: session().device->calls.push_back({DeviceCall::flush, 0}); return;
      case SEGCAL_LOG_CALIBRATE: session().device->calls.push_back({DeviceCall::calibrate, 0}); return;
      case SEGCAL_LOG_REQUEST_CALIBRATION: session().device->calls.push_back({DeviceCall::request, 0}); return;
      case SEGCAL_LOG_LATE: return take_late(block);
      default: fail(name_, block.offset, "expected a mark from 1 to 5, found " + std::to_string(mark));
    }
  }

  void take_late(const LogBlockView& block) {
    std::vector<DeviceCall>& calls = session().device->calls;
    const bool fed =
        !calls.empty() && (calls.back().what == DeviceCall::sample || calls.back().what == DeviceCall::frame);
    if (!fed && !blocks_.damage.empty()) return;  // the call is in what was left out
    if (!fed) fail(name_, block.offset, "expected late work to be noted after a sample or a frame, found it elsewhere");
    calls.back().late = session().device->was_late = true;
  }

  void begin_session() {
    Recording recording;
    recording.root = name_;
    recording.imu.noise = out_.noise;
    recording.imu.has_temperature = has_temperature_;
    recording.cameras.resize(out_.calibration.cameras.size());
    recording.device = DeviceSession{{}, config_, profile_, "", true, false};
    out_.sessions.push_back(recording);
  }

  Recording& session() { return out_.sessions.back(); }

  fs::path name_;
  const LogBlocks& blocks_;
  DeviceLog out_;
  std::string profile_;
  std::vector<std::uint8_t> config_;
  bool has_config_ = false, has_temperature_ = false;
  std::int64_t last_page_ = -1;  ///< of the state
};

}  // namespace

bool is_device_log(const fs::path& file) {
  char first[kLogMagicBytes] = {};
  if (!fs::is_regular_file(file)) return false;
  std::ifstream in(file, std::ios::binary);
  in.read(first, sizeof first);
  return file.extension() == ".segcal" || (in && std::memcmp(first, kLogMagic, sizeof first) == 0);
}

DeviceLog parse_device_log(const fs::path& name, const std::vector<std::uint8_t>& bytes, Damaged damaged) {
  const LogBlocks blocks = find_blocks(bytes);
  std::vector<std::string> notes;
  for (const LogDamage& d : blocks.damage) {
    if (damaged == Damaged::refuse)
      fail(name, d.offset, d.found + " (segcal convert --salvage leaves such blocks out)");
    notes.push_back(name.string() + ": byte " + std::to_string(d.offset) + ": " + d.found + ": " +
                    std::to_string(d.bytes) + " bytes left out");
  }
  if (blocks.torn.bytes > 0) {
    notes.push_back(name.string() + ": byte " + std::to_string(blocks.torn.offset) + ": " + blocks.torn.found +
                    ": the log was cut off here, the last " + std::to_string(blocks.torn.bytes) +
                    " bytes are left out");
  } else if (!blocks.ended) {
    notes.push_back(name.string() + ": byte " + std::to_string(bytes.size()) +
                    ": expected the end mark of a log, found the end of the file: the device did not close it");
  }
  DeviceLog log = Decoder(name, blocks).run();
  if (log.left_state_out)
    notes.push_back(name.string() + ": the device's state that it begins with is left out, since blocks are missing");
  log.notes = notes;
  return log;
}

DeviceLog read_device_log(const fs::path& file, Damaged damaged) {
  return parse_device_log(file, bytes_of(file), damaged);
}

}  // namespace host
