// An emulated board, for tests: the firmware on an ATmega328P of simavr. This program links libsimavr, which is
// GPL-3: it is a program of its own, is built for tests only, and is not part of what sgc is distributed as.
//
//   board FIRMWARE.hex TRACE            in steps: time passes only in the command `run`
//   board FIRMWARE.hex TRACE --pty      in real time, with a pseudo terminal as its serial port
//   board FIRMWARE.hex TRACE --uno      the same, and it resets when the port is opened, as an Uno does
//
// TRACE gets a line for each change of an output: the time in cycles of 1/16 us, the pin, its level; and a line
// "CYCLES reset" for each reset. Commands come on the standard input, a line each, and each is answered with a line:
//
//   run US        let time pass, at most until the board has sent a frame: "ran CYCLES HEX"
//   send HEX      bytes to the board, at the speed of the line
//   cable 0|1     pulled, plugged in
//   stop 0|1      the stop circuit: 1 is open, pressed
//   reset         the reset button
//   hang          the main program loops for ever; interrupts go on
//   freeze        the same without interrupts
//   stop-clock    the interrupt of timer 1 comes no more
//   status        "CYCLES LOWEST": the time, and the lowest the stack pointer has been
//   quit          or the end of the input
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_hex.h>
#include <simavr/sim_interrupts.h>

#define HERTZ 16000000ULL
#define CYCLES_PER_BYTE 1389 // ten bits at 115200 baud: simavr would take a whole buffer at once
#define HANG_AT 0x7FFE       // a loop there, at the end of the flash memory
#define BOOT_CYCLES (HERTZ * 12 / 10)

static avr_t *avr;
static FILE *trace;
static uint8_t levels[20];
static int stop_open, cable = 1;
static uint16_t lowest_stack = 0xFFFF;

static uint8_t input[1 << 16]; // on the way to the board
static size_t input_from, input_to;
static int feeding;
static uint8_t output[1 << 12]; // from the board, in steps
static size_t output_length;
static int frame_ended, terminal = -1;

static void fail(const char *what) {
    fprintf(stderr, "board: %s\n", what);
    exit(1);
}

static void silent(avr_t *a, const int level, const char *format, va_list ap) {
    if (level == LOG_ERROR) vfprintf(stderr, format, ap);
    (void)a;
}

// Arduino numbers: D0 to D13, then A0 to A5.
static void set_level(int pin, int high) {
    if (pin < 3 || levels[pin] == high) return;
    levels[pin] = high;
    fprintf(trace, "%llu %c%d %d\n", (unsigned long long)avr->cycle, pin < 14 ? 'D' : 'A', pin < 14 ? pin : pin - 14, high);
}

static void on_pin(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq;
    set_level((int)(intptr_t)param, value & 1);
}

static void on_sent(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    uint8_t byte = value;
    if (!cable) return;
    if (terminal >= 0) {
        // Nobody listening is no fault of the board.
        if (write(terminal, &byte, 1) != 1) return;
    } else if (output_length < sizeof output) {
        output[output_length++] = byte;
        frame_ended |= byte == 0;
    }
}

static avr_cycle_count_t feed(avr_t *a, avr_cycle_count_t when, void *param) {
    (void)param;
    if (input_from == input_to) {
        feeding = 0;
        input_from = input_to = 0;
        return 0;
    }
    uint8_t byte = input[input_from++];
    if (cable) avr_raise_irq(avr_io_getirq(a, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT), byte);
    return when + CYCLES_PER_BYTE;
}

static void send_bytes(const uint8_t *bytes, size_t length) {
    if (input_to + length > sizeof input) fail("too much input");
    memcpy(input + input_to, bytes, length);
    input_to += length;
    if (!feeding) avr_cycle_timer_register(avr, CYCLES_PER_BYTE, feed, 0);
    feeding = 1;
}

static void drive_stop_pin(void) {
    // Stronger than the pull-up, as a wire to ground is.
    avr_ioport_external_t wire = {.name = 'D', .mask = 1 << 2, .value = stop_open << 2};
    avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('D'), &wire);
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), IOPORT_IRQ_PIN2), stop_open);
}

// After any reset, also one of the watchdog: outputs float, and what simavr forgets is set again.
static void after_reset(void) {
    fprintf(trace, "%llu reset\n", (unsigned long long)avr->cycle);
    for (int pin = 0; pin < 20; pin++) set_level(pin, 0);
    // Else low inputs raise their interrupts for ever, at twenty times the cost.
    avr_extint_set_strict_lvl_trig(avr, 0, 0);
    avr_extint_set_strict_lvl_trig(avr, 1, 0);
    drive_stop_pin();
    input_from = input_to = 0;
    feeding = 0;
}

static void step(void) {
    int state = avr_run(avr);
    if (state == cpu_Done || state == cpu_Crashed) fail("the processor has stopped");
    uint16_t stack = avr->data[R_SPL] | avr->data[R_SPH] << 8;
    // Until the start-up code has set it, it is zero.
    if (stack > 0x100 && stack < lowest_stack) lowest_stack = stack;
    if (avr->pc == 0) after_reset();
}

static void reset_button(void) {
    avr_reset(avr);
    avr_regbit_set(avr, avr->reset_flags.extrf);
    after_reset();
}

static void hang(int interrupts) {
    // In the main program, which sleeps, and not in an interrupt.
    while (avr->state != cpu_Sleeping) step();
    avr->state = cpu_Running;
    avr->flash[HANG_AT] = 0xFF;
    avr->flash[HANG_AT + 1] = 0xCF;
    avr->pc = HANG_AT;
    if (!interrupts) avr->sreg[S_I] = 0;
}

static void run_until(avr_cycle_count_t end) {
    while (avr->cycle < end && !frame_ended) step();
}

static void answer_run(double us) {
    run_until(avr->cycle + (avr_cycle_count_t)(us * 16));
    printf("ran %llu ", (unsigned long long)avr->cycle);
    for (size_t i = 0; i < output_length; i++) printf("%02x", output[i]);
    printf("\n");
    output_length = 0;
    frame_ended = 0;
}

static void command(char *line) {
    char *word = strtok(line, " \n");
    char *argument = strtok(0, " \n");
    if (!word) return;
    if (!strcmp(word, "quit")) exit(0);
    if (!strcmp(word, "run") && argument) {
        answer_run(atof(argument));
        fflush(stdout);
        return;
    }
    if (!strcmp(word, "status")) {
        fflush(trace);
        printf("%llu %u\n", (unsigned long long)avr->cycle, lowest_stack);
        fflush(stdout);
        return;
    }
    if (!strcmp(word, "send") && argument) {
        uint8_t bytes[4096];
        size_t length = 0;
        for (char *c = argument; c[0] && c[1] && length < sizeof bytes; c += 2) {
            char digits[3] = {c[0], c[1], 0};
            bytes[length++] = strtoul(digits, 0, 16);
        }
        send_bytes(bytes, length);
    } else if (!strcmp(word, "cable") && argument) cable = atoi(argument);
    else if (!strcmp(word, "stop") && argument) {
        stop_open = atoi(argument);
        drive_stop_pin();
    } else if (!strcmp(word, "reset")) reset_button();
    else if (!strcmp(word, "hang")) hang(1);
    else if (!strcmp(word, "freeze")) hang(0);
    else if (!strcmp(word, "stop-clock")) avr->data[0x6F] = 0; // TIMSK1
    else fail("what is this command?");
    printf("ok\n");
    fflush(stdout);
}

static void no_sleep(avr_t *a, avr_cycle_count_t cycles) {
    (void)a, (void)cycles;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}

static void open_terminal(void) {
    terminal = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (terminal < 0 || grantpt(terminal) || unlockpt(terminal)) fail("no pseudo terminal");
    // Opened once, for its settings, and closed: until then one does not see that nobody has it open.
    int other = open(ptsname(terminal), O_RDWR | O_NOCTTY);
    struct termios settings;
    if (other < 0 || tcgetattr(other, &settings)) fail("no pseudo terminal");
    cfmakeraw(&settings);
    tcsetattr(other, TCSANOW, &settings);
    close(other);
    printf("pty %s\n", ptsname(terminal));
    fflush(stdout);
}

static void run_in_real_time(int is_uno) {
    open_terminal();
    double begun = now() - (double)avr->cycle / HERTZ;
    int was_open = 0;
    char line[8192];
    for (;;) {
        // What the machine was too busy for is not caught up with: the clock of the board stands still meanwhile.
        double behind = now() - begun - (double)avr->cycle / HERTZ;
        if (behind > 0.02) begun += behind - 0.02;
        run_until((avr_cycle_count_t)((now() - begun) * HERTZ));
        struct pollfd polled[2] = {{0, POLLIN, 0}, {terminal, POLLIN, 0}};
        // Where nobody has the port open, poll returns at once.
        if (!was_open) usleep(1000);
        poll(polled, 2, 1);
        int is_open = !(polled[1].revents & POLLHUP);
        if (is_open && !was_open && is_uno) {
            reset_button();
            avr->cycle += BOOT_CYCLES;
            begun = now() - (double)avr->cycle / HERTZ;
            fflush(trace);
            usleep(BOOT_CYCLES * 1000000 / HERTZ);
            tcflush(terminal, TCIFLUSH);
            uint8_t lost[4096];
            while (read(terminal, lost, sizeof lost) > 0) {}
            begun = now() - (double)avr->cycle / HERTZ;
        }
        was_open = is_open;
        if (polled[1].revents & POLLIN) {
            uint8_t bytes[256];
            ssize_t length = read(terminal, bytes, sizeof bytes);
            if (length > 0 && cable) send_bytes(bytes, length);
        }
        if (polled[0].revents) {
            if (!fgets(line, sizeof line, stdin)) return;
            command(line);
        }
    }
}

int main(int count, char **arguments) {
    if (count < 3) fail("board FIRMWARE.hex TRACE [--pty | --uno]");
    avr_global_logger_set(silent);
    avr = avr_make_mcu_by_name("atmega328p");
    if (!avr) fail("simavr has no atmega328p");
    avr_init(avr);
    avr->frequency = HERTZ;
    avr->log = LOG_ERROR;
    uint32_t size = 0, start = 0;
    uint8_t *code = read_ihex_file(arguments[1], &size, &start);
    if (!code) fail("no firmware");
    avr_loadcode(avr, code, size, start);
    trace = fopen(arguments[2], "w");
    if (!trace) fail("no trace");
    setvbuf(stdin, 0, _IONBF, 0); // what is buffered, poll does not see
    // Its default sleeps as long as the chip does.
    avr->sleep = no_sleep;
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_sent, 0);
    const struct {
        char port;
        int first, pins;
    } ports[] = {{'D', 0, 8}, {'B', 8, 6}, {'C', 14, 6}};
    for (int p = 0; p < 3; p++) {
        for (int i = 0; i < ports[p].pins; i++) {
            avr_irq_t *irq = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(ports[p].port), IOPORT_IRQ_PIN0 + i);
            avr_irq_register_notify(irq, on_pin, (void *)(intptr_t)(ports[p].first + i));
        }
    }
    avr_reset(avr);
    avr_regbit_set(avr, avr->reset_flags.porf);
    after_reset();
    if (count > 3) {
        run_in_real_time(!strcmp(arguments[3], "--uno"));
    } else {
        static char line[1 << 16];
        while (fgets(line, sizeof line, stdin)) command(line);
    }
    return 0;
}
