/* One number for all that a device has found, over the bits: theta with its sigmas, the trajectory, and the database. Two
 * targets that were fed the same log agree in it exactly if and only if they computed the same.
 *
 *   uint64_t hash = SEGCAL_HASH_START;
 *   ... after each frame that moved the filter:  hash = segcal_hash_state(hash, device);
 *   ... at the end:                              hash = segcal_hash_results(hash, device, &work);
 *
 * FNV-1a, 64 bits, over each number's bytes, lowest first, field by field: no padding, no byte order of the machine. C99. */
#ifndef SEGCAL_RESULT_HASH_H
#define SEGCAL_RESULT_HASH_H

#include <string.h>

#include "segcal/segcal.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SEGCAL_HASH_START 0xCBF29CE484222325u

static inline uint64_t segcal_hash_u64(uint64_t hash, uint64_t value) {
  for (int i = 0; i < 8; ++i) hash = (hash ^ ((value >> (8 * i)) & 0xFFu)) * 0x100000001B3u;
  return hash;
}

static inline uint64_t segcal_hash_doubles(uint64_t hash, const double *values, int n) {
  for (int i = 0; i < n; ++i) {
    uint64_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    hash = segcal_hash_u64(hash, bits);
  }
  return hash;
}

static inline uint64_t segcal_hash_one_state(uint64_t hash, const segcal_state_t *state) {
  hash = segcal_hash_u64(hash, (uint64_t)state->t_ns);
  hash = segcal_hash_doubles(hash, state->q_GI, 4);
  hash = segcal_hash_doubles(hash, state->p_GI, 3);
  hash = segcal_hash_doubles(hash, state->v_GI, 3);
  hash = segcal_hash_doubles(hash, state->b_a, 3);
  return segcal_hash_doubles(hash, state->b_g, 3);
}

/* The trajectory: the newest state, if there is one. */
static inline uint64_t segcal_hash_state(uint64_t hash, const segcal_t *device) {
  segcal_state_t state;
  return segcal_get_state(device, &state) == SEGCAL_OK ? segcal_hash_one_state(hash, &state) : hash;
}

/* Room for what is read out at the end; the caller's, so that no stack is needed for it. */
typedef struct {
  segcal_result_t result;
  segcal_segment_t segment;
  segcal_state_t keyframe[SEGCAL_MAX_KEYFRAMES];
  segcal_landmark_t landmark[SEGCAL_MAX_LANDMARKS];
} segcal_hash_work_t;

static inline uint64_t segcal_hash_theta(uint64_t hash, const segcal_t *device, segcal_hash_work_t *work) {
  const segcal_result_t *r = &work->result;
  if (segcal_get_result(device, &work->result) != SEGCAL_OK) return segcal_hash_u64(hash, 0);
  hash = segcal_hash_u64(hash, (uint64_t)r->status);
  for (int i = 0; i < r->n_parameters; ++i) {
    hash = segcal_hash_doubles(hash, &r->parameter[i].value, 1);
    hash = segcal_hash_doubles(hash, &r->parameter[i].sigma, 1);
  }
  return segcal_hash_doubles(hash, &r->chi2, 1);
}

static inline uint64_t segcal_hash_slot(uint64_t hash, const segcal_t *device, int32_t slot, segcal_hash_work_t *work) {
  const segcal_segment_t *s = &work->segment;
  if (segcal_get_segment(device, slot, &work->segment) != SEGCAL_OK) return segcal_hash_u64(hash, 0);
  hash = segcal_hash_u64(hash, (uint64_t)s->start_ns);
  hash = segcal_hash_u64(hash, (uint64_t)s->end_ns);
  hash = segcal_hash_u64(hash, (uint64_t)s->points << 32 | (uint64_t)s->rank);
  hash = segcal_hash_doubles(hash, &s->A, 1);
  hash = segcal_hash_doubles(hash, &s->D, 1);
  hash = segcal_hash_doubles(hash, &s->E, 1);
  hash = segcal_hash_doubles(hash, &s->gain_nats, 1);
  const int keyframes = segcal_get_keyframes(device, slot, work->keyframe, SEGCAL_MAX_KEYFRAMES);
  for (int i = 0; i < keyframes; ++i) hash = segcal_hash_one_state(hash, &work->keyframe[i]);
  const int landmarks = segcal_get_landmarks(device, slot, work->landmark, SEGCAL_MAX_LANDMARKS);
  for (int i = 0; i < landmarks; ++i) {
    hash = segcal_hash_doubles(hash, work->landmark[i].anchor, 3);
    hash = segcal_hash_doubles(hash, work->landmark[i].direction, 3);
    hash = segcal_hash_doubles(hash, &work->landmark[i].inverse_distance, 1);
  }
  return hash;
}

static inline uint64_t segcal_hash_results(uint64_t hash, const segcal_t *device, segcal_hash_work_t *work) {
  hash = segcal_hash_theta(hash, device, work);
  for (int32_t slot = 0; slot <= SEGCAL_MAX_SEGMENTS; ++slot) hash = segcal_hash_slot(hash, device, slot, work);
  return hash;
}

#ifdef __cplusplus
}
#endif
#endif
