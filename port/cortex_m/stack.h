/* The stack is painted at the start; what a call has used is where the paint is gone. */
#ifndef SEGCAL_STACK_H
#define SEGCAL_STACK_H

#include <stdint.h>

/* Paints all that is free below the caller. */
void stack_paint(void);
/* Bytes between the stack's top and the lowest word that lost its paint. */
uint32_t stack_high_water(void);
/* Bytes in use in the caller. */
uint32_t stack_in_use(void);

#endif
