/* A board in QEMU, whose converters are the emulator's standard input and output, by semihosting.
 *
 * In comes, for each sample, every parameter and input, as doubles in the order of SETTABLE. Out go, as doubles, a status,
 * the instructions of the sample, its outputs in the order of READABLE, and in the end the deepest stack. Instructions are
 * counted by the system timer: -icount shift=10 lets 1024 ns pass with each of them. */

#include "board.h"
#include "table.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define COPROCESSORS REGISTER(0xE000ED88)
#define TIMER_CONTROL REGISTER(0xE000E010)
#define TIMER_PERIOD REGISTER(0xE000E014)
#define TIMER REGISTER(0xE000E018)

enum { OPEN = 1, WRITE = 5, READ = 6, EXIT = 24, WHOLE = 0xFFFFFF, TO_READ = 1, TO_WRITE = 5, DONE = 0x20026 };
enum { SETTABLE_COUNT = sizeof SETTABLE / sizeof *SETTABLE, READABLE_COUNT = sizeof READABLE / sizeof *READABLE };

#define TICKS_OF_AN_INSTRUCTION 25.6   /* 1024 ns of 25 MHz */
#define PAINT 0x5A5A5A5Au

extern uint32_t data_begin[], data_end[], data_from[], bss_begin[], bss_end[], stack_begin[], stack_end[];
int main(void);

static struct @NAME@ *controller;
static uint32_t input, output, ticks;
static double from_host[SETTABLE_COUNT], to_host[3 + READABLE_COUNT];
static int32_t status;

static uint32_t host(uint32_t operation, const void *arguments)
{
    register uint32_t first __asm__("r0") = operation;
    register const void *second __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xAB" : "+r"(first) : "r"(second) : "memory");
    return first;
}

static uint32_t opened(const char *name, uint32_t length, uint32_t mode)
{
    const uint32_t arguments[] = {(uint32_t)name, mode, length};
    return host(OPEN, arguments);
}

/* Move all bytes, as often as it takes; whether they were. */
static bool moved(uint32_t operation, uint32_t file, void *bytes, uint32_t size)
{
    while (size > 0) {
        const uint32_t arguments[] = {file, (uint32_t)bytes, size};
        uint32_t left = host(operation, arguments);
        if (left >= size) {
            return false;
        }
        bytes = (char *)bytes + (size - left);
        size = left;
    }
    return true;
}

static uint32_t deepest_stack(void)
{
    const uint32_t *at = stack_begin;
    while (at < stack_end && *at == PAINT) {
        ++at;
    }
    return (uint32_t)((const char *)stack_end - (const char *)at);
}

/* Write a value of the block, or of a port. */
static void put(void *base, const struct Place *place, double value)
{
    char *at = (char *)base + place->offset;
    if (place->boolean) {
        *(bool *)at = value != 0.0;
    } else {
        *(double *)at = value;
    }
}

static double taken(const void *base, const struct Place *place)
{
    const char *at = (const char *)base + place->offset;
    return place->boolean ? *(const bool *)at : *(const double *)at;
}

/* Parameters go to the block; inputs as well, for who reads them there before the first sample. */
static bool receive(void)
{
    if (!moved(READ, input, from_host, sizeof from_host)) {
        return false;
    }
    for (uint32_t i = 0; i < SETTABLE_COUNT; ++i) {
        put(&controller->block, &SETTABLE[i], from_host[i]);
    }
    return true;
}

static void send(const void *base, const struct Place places[])
{
    to_host[0] = status;
    to_host[1] = (double)(uint32_t)(ticks / TICKS_OF_AN_INSTRUCTION + 0.5);
    to_host[2] = deepest_stack();
    for (uint32_t i = 0; i < READABLE_COUNT; ++i) {
        to_host[3 + i] = taken(base, &places[i]);
    }
    moved(WRITE, output, to_host, sizeof to_host);
}

void board_begin(struct @NAME@ *self)
{
    controller = self;
    input = opened("/dev/stdin", 10, TO_READ);
    output = opened("/dev/stdout", 11, TO_WRITE);
    receive();
}

int32_t __real_@NAME@_start(struct @NAME@ *self);
int32_t __real_@NAME@_sample(struct @NAME@ *self, const struct @NAME@_inputs *inputs, struct @NAME@_outputs *outputs);

/* The linker puts these around the controller's functions. */
int32_t __wrap_@NAME@_start(struct @NAME@ *self)
{
    uint32_t before = TIMER;
    status = __real_@NAME@_start(self);
    ticks = (before - TIMER) & WHOLE;
    send(&controller->block, READABLE);
    return status;
}

int32_t __wrap_@NAME@_sample(struct @NAME@ *self, const struct @NAME@_inputs *inputs, struct @NAME@_outputs *outputs)
{
    uint32_t before = TIMER;
    status = __real_@NAME@_sample(self, inputs, outputs);
    ticks = (before - TIMER) & WHOLE;
    return status;
}

bool board_read(struct @NAME@_inputs *inputs)
{
    if (!receive()) {
        return false;
    }
    for (uint32_t i = 0; i < sizeof INPUTS / sizeof *INPUTS; ++i) {
        put(inputs, &INPUTS[i].place, from_host[INPUTS[i].settable]);
    }
    return true;
}

void board_write(const struct @NAME@_outputs *outputs)
{
    send(outputs, OUTPUTS);
}

void board_end(int32_t end)
{
    if (end != 0) {   /* of a sample that is refused nothing was written */
        send(&controller->block, READABLE);
    }
    host(EXIT, (const void *)DONE);
}

/* Reset, and the handler of faults, which cannot be repaired. */
static void reset(void)
{
    COPROCESSORS |= 0xF << 20;   /* the floating-point unit */
    __asm__ volatile("dsb\n isb");
    for (uint32_t *to = data_begin, *from = data_from; to < data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = bss_begin; to < bss_end;) {
        *to++ = 0;
    }
    uint32_t *here = __builtin_frame_address(0);
    for (uint32_t *to = stack_begin; to < here - 16;) {
        *to++ = PAINT;
    }
    TIMER_PERIOD = WHOLE;
    TIMER = 0;
    TIMER_CONTROL = 5;
    main();
}

static void fault(void)
{
    host(EXIT, (const void *)0x20023);
}

__attribute__((section(".vectors"), used)) static const void *const VECTORS[16] = {
    stack_end, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault,
    (const void *)fault};
