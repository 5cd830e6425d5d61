/* What a bare Cortex-M4F needs before main, and what stands in for a debugger's
 * console (Arm semihosting, as QEMU has it).
 *
 * In: a program with main, and put() to print. Out: an image for the start of
 * flash. No library is linked. */
#include <stddef.h>
#include <stdint.h>

int main(void);
void put(const char *text);
uint32_t ticks(void);

extern uint32_t stack_top[];
void reset(void);
void stuck(void);

__attribute__((section(".vectors"),
               used)) static const uintptr_t vectors[16] = {
    (uintptr_t)stack_top, (uintptr_t)reset, (uintptr_t)stuck, (uintptr_t)stuck,
    (uintptr_t)stuck,     (uintptr_t)stuck, (uintptr_t)stuck, (uintptr_t)stuck,
    (uintptr_t)stuck,     (uintptr_t)stuck, (uintptr_t)stuck, (uintptr_t)stuck,
    (uintptr_t)stuck,     (uintptr_t)stuck, (uintptr_t)stuck, (uintptr_t)stuck};

static void ask_host(uint32_t operation, uintptr_t argument) {
  register uint32_t r0 __asm__("r0") = operation;
  register uintptr_t r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void put(const char *text) { ask_host(0x04, (uintptr_t)text); /* SYS_WRITE0 */ }

/* Of the processor's clock, counting down from 2^24 */
uint32_t ticks(void) { return *(volatile uint32_t *)0xe000e018; }

void stuck(void) {
  put("fault\n");
  ask_host(0x18, 0x20024); /* SYS_EXIT, internal error */
  for (;;) {
  }
}

void reset(void) {
  *(volatile uint32_t *)0xe000ed88 |= 0xfu << 20; /* CPACR: the FPU is on */
  __asm__ volatile("dsb\n isb");
  *(volatile uint32_t *)0xe000e014 =
      0xffffffu; /* SysTick: reload, then from the processor's clock */
  *(volatile uint32_t *)0xe000e018 = 0;
  *(volatile uint32_t *)0xe000e010 = 5;
  ask_host(0x18,
           main() == 0 ? 0x20026u : 0x20024u); /* SYS_EXIT: application exit */
  for (;;) {
  }
}

/* Compilers call these for structs, whether a program says so or not */
void *memcpy(void *to, const void *from, size_t count);
void *memset(void *to, int value, size_t count);

void *memcpy(void *to, const void *from, size_t count) {
  for (size_t i = 0; i < count; i++)
    ((volatile unsigned char *)to)[i] = ((const unsigned char *)from)[i];
  return to;
}

void *memset(void *to, int value, size_t count) {
  for (size_t i = 0; i < count; i++)
    ((volatile unsigned char *)to)[i] = (unsigned char)value;
  return to;
}
