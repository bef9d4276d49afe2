/* Where a device's memory is: in two blocks, and moved or kept as bytes.
 *
 * A device works in its hot block for each sample and image: the filter, the memory of its work, results. The cold one,
 * more than half of all, holds segments, the open one too, and what a calibration needs. An image reads a few words of
 * it and a keyframe is copied there: slower RAM will do, but it must be on. `segcal_create` has both in one block.
 *
 *     static char hot[SEGCAL_HOT_BYTES] IN_TIGHTLY_COUPLED_RAM;   aligned to SEGCAL_STORAGE_ALIGNMENT
 *     static char cold[SEGCAL_COLD_BYTES];                        so is this
 *     segcal_create_in_blocks(&device, &config, hot, sizeof hot, cold, sizeof cold);
 *
 * No part holds an address. After its bytes were copied to other places, or to a file and back into RAM, segcal_attach
 * gives the device, which goes on with the same bits; the program and its library must be those that wrote the bytes.
 * (What must survive a power cut or a new program belongs in a store, store.h.) A segcal_store_t under way is not to be
 * moved from under: let it finish before.
 */
#ifndef SEGCAL_BLOCKS_H
#define SEGCAL_BLOCKS_H

#include "segcal/segcal.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* The exact figures below SEGCAL_HOT_BYTES and SEGCAL_COLD_BYTES. */
size_t segcal_hot_bytes(void);
size_t segcal_cold_bytes(void);

/* segcal_create_for and segcal_create in two blocks (any content, aligned to SEGCAL_STORAGE_ALIGNMENT).
   SEGCAL_ERROR_SIZE: one is too small, or they overlap. */
int segcal_create_in_blocks_for(segcal_t** device, const segcal_config_t* config, void* hot, size_t hot_bytes,
                                void* cold, size_t cold_bytes, const uint32_t* capacities);
static inline int segcal_create_in_blocks(segcal_t** device, const segcal_config_t* config, void* hot, size_t hot_bytes,
                                          void* cold, size_t cold_bytes) {
  const uint32_t capacities[SEGCAL_N_CAPACITIES] = SEGCAL_CAPACITIES;
  return segcal_create_in_blocks_for(device, config, hot, hot_bytes, cold, cold_bytes, capacities);
}

/* The device whose bytes are at `hot` and `cold` now; `cold` null: it was created in one block, which is at `hot`, and
   may have moved at any moment. Two blocks that have moved by different distances: while nothing is pending, else
   SEGCAL_ERROR_BUSY, and they are a device only where they were (segcal_background until it returns 0, before they are
   copied). SEGCAL_ERROR_STATE: these are not the bytes of a device of this library, or not two blocks of the same one,
   as far as their heads tell: a byte that changed elsewhere is not noticed, as it is in a store. The old places are no
   device any more. */
int segcal_attach(segcal_t** device, void* hot, void* cold);

#ifdef __cplusplus
}
#endif
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif

#endif
