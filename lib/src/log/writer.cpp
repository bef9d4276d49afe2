// Writes a device log block by block (segcal/log.h).
#include "log/block_writer.h"
#include "log/config_fields.h"

namespace SEGCAL_NS {
namespace {

/// Everything a reader must know before it makes sense of the rest.
int write_header(segcal_log_t* log) {
  if (write(log, kLogMagic, kLogMagicBytes) != SEGCAL_OK) return SEGCAL_ERROR_STATE;
  ByteWriter out = payload_of(*log);
  const std::uint32_t numbers[] = {SEGCAL_LOG_FORMAT,         SEGCAL_VERSION,          sizeof(SEGCAL_REAL),
                                   SEGCAL_MAX_CAMERAS,        SEGCAL_MAX_SEGMENTS,     SEGCAL_MAX_KEYFRAMES,
                                   SEGCAL_MAX_LANDMARKS,      SEGCAL_MAX_OBSERVATIONS, SEGCAL_MAX_IMU_SAMPLES,
                                   SEGCAL_MAX_CLONES,         SEGCAL_MAX_TRACKS,       SEGCAL_MAX_TIES,
                                   SEGCAL_SHARED_LANDMARKS,   SEGCAL_IMU_HISTORY,      SEGCAL_MAX_EFFECT_ESTIMATES,
                                   SEGCAL_MAX_EFFECT_COLUMNS, SEGCAL_FRAME_FEATURES,   SEGCAL_START_DELAY_MS,
                                   SEGCAL_PIXEL_BITS,         SEGCAL_WAITING_FRAMES,   SEGCAL_MAX_EPOCHS};
  for (std::uint32_t n : numbers) out.integer(n);
  return write_block(log, LogBlock::header, out.size());
}

int write_config(segcal_log_t* log, const segcal_config_t& config) {
  ByteWriter out = payload_of(*log);
  ConfigWriter fields(&out);
  config_fields(&config, &fields);
  return out.fits() ? write_block(log, LogBlock::config, out.size()) : SEGCAL_ERROR_SIZE;
}

/// Behind it a state would come too late; before an announced one is whole, it would be lost.
int start_fed(segcal_log_t* log) {
  const int error = log && log->awaits_state ? SEGCAL_ERROR_STATE : start(log);
  if (error == SEGCAL_OK) log->fed = 1;
  return error;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

int segcal_log_begin(segcal_log_t* log, const segcal_config_t* config, uint8_t* block, size_t block_bytes,
                     segcal_log_write_t write, void* context) {
  if (!log || !config || !block || !write) return SEGCAL_ERROR_NULL;
  if (block_bytes < SEGCAL_LOG_BLOCK_BYTES) return SEGCAL_ERROR_SIZE;
  *log = segcal_log_t{};
  log->write = write;
  log->context = context;
  log->block = block;
  log->capacity = block_bytes;
  const int error = write_header(log);
  return error == SEGCAL_OK ? write_config(log, *config) : error;
}

int segcal_log_imu(segcal_log_t* log, const segcal_imu_t* sample) {
  if (!log || !sample || !log->write) return SEGCAL_ERROR_NULL;
  // The stamp is kept as its distance from the block's first: 2 s either way, else a new block begins.
  const std::int64_t dt =
      static_cast<std::int64_t>(static_cast<std::uint64_t>(sample->t_ns) - static_cast<std::uint64_t>(log->t0_ns));
  const bool room = kBlockHead + log->used + kImuSample + kBlockTail <= log->capacity;
  if (log->samples > 0 && (!room || dt > INT32_MAX || dt < INT32_MIN)) finish_samples(log);
  if (log->failed || log->awaits_state) return SEGCAL_ERROR_STATE;
  log->fed = 1;
  if (log->samples == 0) {
    log->t0_ns = sample->t_ns;
    log->used = kImuHead;
  }
  ByteWriter out(log->block + kBlockHead + log->used, kImuSample);
  out.integer(static_cast<std::int32_t>(log->samples == 0 ? 0 : dt));
  for (float value : sample->gyro) out.number(value);
  for (float value : sample->accel) out.number(value);
  out.number(sample->temperature);
  log->used += kImuSample;
  ++log->samples;
  return SEGCAL_OK;
}

int segcal_log_tracks(segcal_log_t* log, int64_t t_ns, const segcal_point_t* points, int32_t n) {
  if (!points && n > 0) return SEGCAL_ERROR_NULL;
  if (n < 0 || n > SEGCAL_MAX_TRACKS * SEGCAL_MAX_CAMERAS) return SEGCAL_ERROR_SIZE;
  const int error = start_fed(log);
  if (error != SEGCAL_OK) return error;
  ByteWriter out = payload_of(*log);
  out.integer(t_ns);
  out.integer(n);
  for (int32_t i = 0; i < n; ++i) {
    out.integer(points[i].track_id);
    out.integer(static_cast<std::uint8_t>(points[i].camera));
    out.number(points[i].u);
    out.number(points[i].v);
  }
  return out.fits() ? write_block(log, LogBlock::tracks, out.size()) : SEGCAL_ERROR_SIZE;
}

int segcal_log_mark(segcal_log_t* log, int32_t mark) {
  if (mark < SEGCAL_LOG_NEW_SESSION || mark > SEGCAL_LOG_LATE) return SEGCAL_ERROR_SIZE;
  const int error = start_fed(log);
  if (error != SEGCAL_OK) return error;
  ByteWriter out = payload_of(*log);
  out.integer(mark);
  return write_block(log, LogBlock::mark, out.size());
}

int segcal_log_fed(segcal_log_t* log, const segcal_t* device) {
  segcal_progress_t progress;
  const int error = segcal_progress(device, &progress);
  if (!log || error != SEGCAL_OK) return log ? error : SEGCAL_ERROR_NULL;
  if (progress.late == log->late) return SEGCAL_OK;
  log->late = progress.late;
  return segcal_log_mark(log, SEGCAL_LOG_LATE);
}

int segcal_log_hash(segcal_log_t* log, uint64_t hash) {
  const int error = start_fed(log);
  if (error != SEGCAL_OK) return error;
  ByteWriter out = payload_of(*log);
  out.integer(hash);
  return write_block(log, LogBlock::hash, out.size());
}

int segcal_log_sync(segcal_log_t* log) { return start(log); }

int segcal_log_end(segcal_log_t* log) {
  const int error = start_fed(log);
  return error == SEGCAL_OK ? write_block(log, LogBlock::end, 0) : error;
}

}  // extern "C"
