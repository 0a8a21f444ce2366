// frame_soak: feeds standard input to a frame receiver, one byte per cycle, and prints a line for
// each body ("F" or, if plain, "P", then its bytes) and each dropped frame ("M", "C" or "O"), then
// the state of `line_busy`. A pseudo-random pause of up to `argv[1]` cycles precedes each body.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <verilated.h>

#include "Vtop.h"

int main(int argc, char** argv) {
    const auto longest_pause = argc > 1 ? static_cast<unsigned>(std::atoi(argv[1])) : 0;
    VerilatedContext context;
    Vtop chip{&context, ""};
    std::string body;
    std::uint32_t random = 1;
    unsigned pause = 0;

    const auto cycle = [&](int byte) {
        chip.bytes___05Fvalid = byte != EOF;
        chip.bytes___05Fpayload = byte != EOF ? byte : 0;
        chip.requests___05Fready = pause == 0;
        chip.clk = 0;
        chip.eval();
        if (pause != 0) {
            --pause;
        } else if (chip.requests___05Fvalid) {
            char text[3];
            const unsigned word = chip.requests___05Fpayload;
            std::snprintf(text, sizeof text, "%02x", word & 0xff);
            body += text;
            if (word >> 8 & 1) {
                std::printf("%c%s\n", word >> 9 & 1 ? 'P' : 'F', body.c_str());
                body.clear();
                random = random * 1664525 + 1013904223;
                pause = longest_pause ? (random >> 8) % (longest_pause + 1) : 0;
            }
        }
        if (chip.malformed) std::puts("M");
        if (chip.crc_error) std::puts("C");
        if (chip.overrun) std::puts("O");
        chip.clk = 1;
        chip.eval();
    };

    chip.rst = 0;
    for (int byte; (byte = std::getchar()) != EOF;) cycle(byte);
    for (unsigned i = 0; i < 100000; ++i) cycle(EOF);
    std::printf("busy %d\n", chip.line_busy);
    chip.final();
    return 0;
}
