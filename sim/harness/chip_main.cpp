// chip_main CLOCKS_PER_BIT: a Verilated chip whose time passes by order.
//
// Orders come on standard input: two 64-bit little-endian numbers, then bytes.
//
//   1 n bytes  sends n bytes to the chip, and runs until the last has been sent
//   2 n        runs n cycles, or until the chip has sent a whole frame
//   3 n        runs n cycles, then holds the reset for one
//   4 n bytes  writes the counts of coverage to the file of this name, if the chip was built to
//              count
//
// The answer to each is two numbers, the bytes that the chip has sent meanwhile and the cycles that
// have passed, and then the bytes.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <verilated.h>
#if VM_COVERAGE
#include <verilated_cov.h>
#endif

#include "Vtop.h"
#include "../board/uart.hpp"

namespace {

using Number = std::uint64_t;

class Chip {
public:
    explicit Chip(unsigned clocks_per_bit)
        : driver_{clocks_per_bit}, sampler_{clocks_per_bit} {
        top_.rx = 1;
        reset();
    }

    void send(const std::vector<std::uint8_t>& bytes) {
        driver_.push(bytes.data(), bytes.size());
        while (!driver_.idle()) clock();
    }

    void run(Number cycles, bool to_frame) {
        frames_ = 0;
        for (Number cycle = 0; cycle < cycles && !(to_frame && frames_ > 0); ++cycle) clock();
    }

    void reset() {
        top_.rst = 1;
        clock();
        top_.rst = 0;
    }

    void answer() {
        const Number numbers[] = {sent_.size(), cycles_};
        std::fwrite(numbers, sizeof numbers, 1, stdout);
        std::fwrite(sent_.data(), 1, sent_.size(), stdout);
        std::fflush(stdout);
        sent_.clear();
        cycles_ = 0;
    }

private:
    void clock() {
        top_.rx = driver_.clock();
        top_.clk = 0;
        top_.eval();
        top_.clk = 1;
        top_.eval();
        ++cycles_;
        if (sampler_.clock(top_.tx) == board::UartSampler::Event::kByte) {
            sent_.push_back(sampler_.byte());
            frames_ += sampler_.byte() == 0;
        }
    }

    Vtop top_;
    board::UartDriver driver_;
    board::UartSampler sampler_;
    std::vector<std::uint8_t> sent_;
    Number cycles_ = 0;
    Number frames_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    Chip chip{static_cast<unsigned>(std::atoi(argv[1]))};
    Number order[2];
    while (std::fread(order, sizeof order, 1, stdin) == 1) {
        if (order[0] == 1 || order[0] == 4) {
            std::vector<std::uint8_t> bytes(order[1]);
            if (std::fread(bytes.data(), 1, bytes.size(), stdin) != bytes.size()) return 3;
            if (order[0] == 1) chip.send(bytes);
#if VM_COVERAGE
            if (order[0] == 4) {
                const std::string path(bytes.begin(), bytes.end());
                Verilated::threadContextp()->coveragep()->write(path);
            }
#endif
        } else {
            chip.run(order[1], order[0] == 2);
            if (order[0] == 3) chip.reset();
        }
        chip.answer();
    }
    return 0;
}
