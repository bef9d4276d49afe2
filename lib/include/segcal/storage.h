/* The ledger of all memory, in bytes: what each part costs with the capacities in config.h. */
#ifndef SEGCAL_STORAGE_H
#define SEGCAL_STORAGE_H

#define SEGCAL_STORAGE_BYTES 20000000u

#endif
