/* From reset to main for Armv7-M and Armv8-M, without the C library's start and without its heap. */
#include <stdint.h>

#include "semihosting.h"
#include "stack.h"

extern uint32_t __stack_top, __stack_limit, __data_load, __data_start, __data_end, __bss_start, __bss_end;
extern int main(void);
void Reset_Handler(void);

enum { kPaint = 0x5E6CA11E };
/* The frame of the painting function itself lies within this many words of its stack pointer. */
enum { kSpareWords = 8 };

static void Nmi_Handler(void) {
  semihosting_write("unexpected NMI\n");
  semihosting_exit(99);
}

/* With the Configurable Fault Status Register: bit 20 of it says that the stack's limit was passed. */
static void Fault_Handler(void) {
  static char text[] = "fault, CFSR 0x........\n";
  const uint32_t cfsr = *(volatile uint32_t*)0xE000ED28u;
  for (int i = 0; i < 8; ++i) text[14 + i] = "0123456789abcdef"[(cfsr >> (28 - 4 * i)) & 15u];
  semihosting_write(text);
  semihosting_exit(99);
}

#define VECTOR(address) ((void (*)(void))(address))
__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {VECTOR(&__stack_top),
                                                                                     Reset_Handler,
                                                                                     Nmi_Handler,
                                                                                     Fault_Handler,
                                                                                     Fault_Handler,
                                                                                     Fault_Handler,
                                                                                     Fault_Handler,
                                                                                     Fault_Handler,
                                                                                     0,
                                                                                     0,
                                                                                     0,
                                                                                     Fault_Handler,
                                                                                     Fault_Handler,
                                                                                     0,
                                                                                     Fault_Handler,
                                                                                     Fault_Handler};

static uint32_t* stack_pointer(void) {
  uint32_t* sp;
  __asm volatile("mov %0, sp" : "=r"(sp));
  return sp;
}

__attribute__((noinline)) void stack_paint(void) {
  for (volatile uint32_t* p = &__stack_limit; p < stack_pointer() - kSpareWords; ++p) *p = kPaint;
}

uint32_t stack_high_water(void) {
  const volatile uint32_t* p = &__stack_limit;
  while (p < &__stack_top && *p == kPaint) ++p;
  return (uint32_t)((const volatile char*)&__stack_top - (const volatile char*)p);
}

uint32_t stack_in_use(void) { return (uint32_t)((char*)&__stack_top - (char*)stack_pointer()); }

__attribute__((noreturn, used)) static void start(void) {
#if defined(__ARM_FP)
  *(volatile uint32_t*)0xE000ED88u |= 0xFu << 20; /* CPACR: full access to the floating-point unit, and MVE */
#endif
#if defined(__ARM_ARCH_8M_MAIN__) || defined(__ARM_ARCH_8_1M_MAIN__)
  __asm volatile("msr msplim, %0" ::"r"(&__stack_limit)); /* an overflow faults instead of writing over data */
#endif
  __asm volatile("dsb\n isb" ::: "memory");
  for (uint32_t *to = &__data_start, *from = &__data_load; to < &__data_end;) *to++ = *from++;
  for (uint32_t* to = &__bss_start; to < &__bss_end;) *to++ = 0;
  stack_paint();
  semihosting_exit(main());
}

__attribute__((naked, used)) void Reset_Handler(void) { __asm volatile("ldr r0, =__stack_top\n mov sp, r0\n b start"); }
