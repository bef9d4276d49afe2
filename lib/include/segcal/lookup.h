/* A sentence for each return code, and the parameters of a result by name. Inline, so that firmware that does not use
   them does not carry them. */
#ifndef SEGCAL_LOOKUP_H
#define SEGCAL_LOOKUP_H

#include "segcal/segcal.h"

/* What a call returned: an event or an error. */
static inline const char* segcal_code_words(int code) {
  switch (code) {
    case SEGCAL_OK: return "done";
    case SEGCAL_WAITING: return "taken; more data is needed before anything comes of it";
    case SEGCAL_SKIPPED: return "a frame sooner than frame_interval_s after the last one used, or without room to wait";
    case SEGCAL_TRACKING: return "the frame moved the filter";
    case SEGCAL_LOST: return "tracking was lost, the filter starts again";
    case SEGCAL_NO_RESULT: return "a calibration ran, but nothing is released: the result's status says why";
    case SEGCAL_EMPTY: return "nothing is stored";
    case SEGCAL_ERROR_NULL: return "a pointer is null";
    case SEGCAL_ERROR_SIZE: return "the storage is smaller than segcal_storage_bytes(), or a count is out of range";
    case SEGCAL_ERROR_ALIGNMENT: return "the storage is not aligned to SEGCAL_STORAGE_ALIGNMENT";
    case SEGCAL_ERROR_CONFIG: return "a value of the configuration is out of its range";
    case SEGCAL_ERROR_NOT_FINITE: return "a sample has a value that is not a number or not finite: it was dropped";
    case SEGCAL_ERROR_STAMP: return "a stamp repeats, goes back or is far from its neighbours: it was dropped";
    case SEGCAL_ERROR_CAMERA: return "a camera's index is out of range";
    case SEGCAL_ERROR_STATE: return "the call is not possible now: no device, no segment or no result";
    case SEGCAL_ERROR_BUSY:
      return "background work is under way and moves what was asked for: ask again when it has taken effect";
    case SEGCAL_ERROR_CAPACITY:
      return "program and library were compiled with other capacities: segcal_explain_capacities says which";
    case SEGCAL_ERROR_STORAGE: return "the flash failed";
    case SEGCAL_ERROR_FULL: return "the flash has too few good blocks";
    case SEGCAL_ERROR_VERSION: return "what is stored was written by a newer format";
    default: return "unknown";
  }
}

/* The parameter with this name ("cam0.fx", "gyro.sx", "time_offset.t_d"); null if the result has none. */
static inline const segcal_parameter_t* segcal_find_parameter(const segcal_result_t* result, const char* name) {
  for (int32_t i = 0; i < result->n_parameters; ++i) {
    const char *a = result->parameter[i].name, *b = name;
    while (*a && *a == *b) {
      ++a;
      ++b;
    }
    if (*a == *b) return &result->parameter[i];
  }
  return 0;
}

#endif
