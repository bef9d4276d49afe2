/* Semihosting: what a debugger or QEMU gives an image. For the board ports of this folder, not for products. */
#ifndef SEGCAL_SEMIHOSTING_H
#define SEGCAL_SEMIHOSTING_H

void semihosting_write(const char* text);
void semihosting_write_char(char c);
/* Ends the emulation; `code` becomes the emulator's exit code. */
void semihosting_exit(int code) __attribute__((noreturn));
/* Hundredths of a second since the start. */
unsigned semihosting_clock(void);

#endif
