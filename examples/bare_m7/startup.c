/* From reset to main. */
#include <stdint.h>

extern uint32_t stack_top[], data_in_flash[], data_begin[], data_end[], bss_begin[], bss_end[];
int main(void);
void finish(int code);

__attribute__((used)) static void start(void) {
  const uint32_t* from = data_in_flash;
  *(volatile uint32_t*)0xE000ED88u |= 0xFu << 20; /* CPACR: the floating-point unit is on */
  __asm volatile("dsb\n isb" ::: "memory");
  for (uint32_t* to = data_begin; to < data_end;) *to++ = *from++;
  for (uint32_t* to = bss_begin; to < bss_end;) *to++ = 0;
  finish(main());
}

void reset(void) { start(); }
static void fault(void) { finish(99); }

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))stack_top, reset, fault, fault, fault, fault, fault};
