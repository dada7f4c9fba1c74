/*
 * Start of a program on a Cortex-M4 with newlib's semihosting (--specs=rdimon.specs): the vector table, and a reset
 * handler that turns the floating-point unit on. For the board mps2-an386, as qemu-system-arm emulates it.
 */
#include <stdint.h>

/* Of newlib: clears memory, asks the debugger for the arguments, calls main and exits. */
extern void _start(void);
void reset(void);


__attribute__((naked)) void reset(void) {
    __asm volatile("ldr r0, =0xe000ed88\n"
                   "ldr r1, [r0]\n"
                   "orr r1, r1, #0x00f00000\n"
                   "str r1, [r0]\n"
                   "dsb\n"
                   "isb\n"
                   "b _start\n");
}

/* The first stack pointer is the end of the board's 4 MiB of data memory. */
__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    (const void *)0x20400000,
    (const void *)(uintptr_t)reset,
};
