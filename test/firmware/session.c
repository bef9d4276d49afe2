#include "session.h"

#include <string.h>

/* Layout: see pack_session.py. */
typedef struct {
  char magic[8];
  uint32_t samples, frames, points, period_ns;
  float gyro_lsb, accel_lsb, pixel_lsb; /* rad/s, m/s^2, px */
  uint32_t unused;
} header_t;

enum { kSampleBytes = 12, kFrameHeaderBytes = 8, kPointBytes = 6 };
static const int64_t start_ns = 1000000000;

extern const unsigned char session_data[], session_data_end[];

static const header_t* header(void) { return (const header_t*)(const void*)session_data; }

static uint16_t u16(const unsigned char* at) { return (uint16_t)(at[0] | at[1] << 8); }
static int16_t i16(const unsigned char* at) { return (int16_t)u16(at); }
static uint32_t u32(const unsigned char* at) { return u16(at) | (uint32_t)u16(at + 2) << 16; }

static uint32_t frames_begin(void) { return (uint32_t)sizeof(header_t) + header()->samples * kSampleBytes; }

int session_valid(void) {
  const header_t* h = header();
  const uint32_t size = (uint32_t)(session_data_end - session_data);
  return size > sizeof *h && memcmp(h->magic, "SEGSESS1", 8) == 0 &&
         size == frames_begin() + h->frames * kFrameHeaderBytes + h->points * kPointBytes;
}

uint32_t session_samples(void) { return header()->samples; }
uint32_t session_frames(void) { return header()->frames; }

segcal_imu_t session_sample(uint32_t index) {
  const unsigned char* at = session_data + sizeof(header_t) + index * kSampleBytes;
  segcal_imu_t sample;
  sample.t_ns = start_ns + (int64_t)index * header()->period_ns;
  for (int i = 0; i < 3; ++i) {
    sample.gyro[i] = (float)i16(at + 2 * i) * header()->gyro_lsb;
    sample.accel[i] = (float)i16(at + 6 + 2 * i) * header()->accel_lsb;
  }
  return sample;
}

void session_first_frame(session_frame_t* at) { at->offset = frames_begin(); }

int32_t session_next_frame(session_frame_t* at, int64_t* t_ns, segcal_point_t points[SEGCAL_MAX_TRACKS]) {
  const unsigned char* from = session_data + at->offset;
  const uint32_t stored = u32(from + 4);
  int32_t n = 0;
  *t_ns = start_ns + (int64_t)u32(from) * 1000;
  from += kFrameHeaderBytes;
  at->offset += kFrameHeaderBytes + stored * kPointBytes;
  for (; n < (int32_t)stored && n < SEGCAL_MAX_TRACKS; ++n, from += kPointBytes) {
    points[n].track_id = u16(from);
    points[n].camera = 0;
    points[n].u = (float)u16(from + 2) * header()->pixel_lsb;
    points[n].v = (float)u16(from + 4) * header()->pixel_lsb;
  }
  return n;
}

void session_feed(session_order_t order, void (*sample)(uint32_t index, const segcal_imu_t* sample),
                  void (*frame)(int64_t t_ns, const segcal_point_t* points, int32_t n)) {
  static segcal_point_t points[SEGCAL_MAX_TRACKS];
  session_frame_t at;
  uint32_t next = 0;
  session_first_frame(&at);
  for (uint32_t i = 0; i < session_frames(); ++i) {
    int64_t t_ns;
    const int32_t n = session_next_frame(&at, &t_ns, points);
    for (int reached = 0; !reached && next < session_samples();) {
      const segcal_imu_t s = session_sample(next);
      reached = order == SESSION_NATURAL_ORDER ? s.t_ns > t_ns : s.t_ns >= t_ns;
      if (order == SESSION_FRAME_AFTER_SAMPLE || !reached) sample(next++, &s);
    }
    frame(t_ns, points, n);
  }
}

void session_config(segcal_config_t* config) {
  static const segcal_camera_t data_sheet = {SEGCAL_FOV,
                                             {0.45686248, 0.51683624, -0.52183405, 0.50184280},
                                             {0.05741690, -0.01500375, -0.03358849},
                                             {256, 256, 319.5, 239.5},
                                             {0.92},
                                             480};
  memset(config, 0, sizeof *config);
  config->camera[0] = data_sheet;
}
