/* The run of host.c on the Cortex-M7 of QEMU's machine mps2-an500: a digest onto its standard output, by semihosting.

   What starts, links and talks is as in maglev/fmi/target/qemu, which is of controllers. */

enum { OPEN = 1, WRITE = 5, EXIT = 24, TO_WRITE = 5, DONE = 0x20026, FAULT = 0x20023 };

extern uint32_t data_begin[], data_end[], data_from[], bss_begin[], bss_end[], stack_end[];

static uint32_t host(uint32_t operation, const void *arguments)
{
    register uint32_t first __asm__("r0") = operation;
    register const void *second __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xAB" : "+r"(first) : "r"(second) : "memory");
    return first;
}

static void write(uint64_t digest)
{
    char digits[16];
    for (int place = 15; place >= 0; --place) {
        digits[place] = "0123456789abcdef"[digest & 15];
        digest >>= 4;
    }
    const uint32_t output[] = {(uint32_t)"/dev/stdout", TO_WRITE, 11};
    const uint32_t text[] = {host(OPEN, output), (uint32_t)digits, sizeof digits};
    host(WRITE, text);
}

/* A function of its own: it may begin by keeping registers of the floating-point unit. */
static __attribute__((noinline)) void begin(void)
{
    for (uint32_t *to = data_begin, *from = data_from; to < data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = bss_begin; to < bss_end;) {
        *to++ = 0;
    }
    write(run());
    host(EXIT, (const void *)DONE);
}

/* At reset the floating-point unit is off. */
static void reset(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xF << 20;
    __asm__ volatile("dsb\n isb");
    begin();
}

static void fault(void)
{
    host(EXIT, (const void *)FAULT);
}

__attribute__((section(".vectors"), used)) static const void *const VECTORS[16] = {
    stack_end, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault,
    (const void *)fault};
