// Parts of a harness: numbers on standard input and output, all 64-bit little-endian, and the clock
// of a Verilated design.
//
// Verilator spells the double underscore of a port ___05F.

#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <verilated.h>

#include "Vtop.h"

namespace harness {

using Number = std::uint64_t;
using Numbers = std::vector<Number>;

inline bool next_order(Number& order) {
    std::fflush(stdout);
    return std::fread(&order, sizeof order, 1, stdin) == 1;
}

inline Numbers read_numbers(std::size_t count) {
    Numbers numbers(count);
    if (std::fread(numbers.data(), sizeof(Number), count, stdin) != count) std::exit(3);
    return numbers;
}

inline Number read_number() { return read_numbers(1)[0]; }

inline void write_numbers(const Numbers& numbers) {
    std::fwrite(numbers.data(), sizeof(Number), numbers.size(), stdout);
}

// The bits of a port as numbers.
template <class Port>
Numbers read_port(const Port& port) {
    Numbers numbers((sizeof(Port) + sizeof(Number) - 1) / sizeof(Number), 0);
    std::memcpy(numbers.data(), &port, sizeof(Port));
    return numbers;
}

// Pauses of a stream: it moves in about one cycle of `stall`, or in every one.
class Pauses {
public:
    explicit Pauses(Number stall) : stall_{stall} {}

    void draw() { random_ ^= random_ << 13, random_ ^= random_ >> 7, random_ ^= random_ << 17; }

    bool moves(int stream = 0) const { return stall_ == 0 || (random_ >> 20 * stream) % stall_ == 0; }

private:
    Number stall_;
    Number random_ = 88172645463325252ULL;
};

// A design after its reset. Between two clocks its clock is low, and its outputs have settled.
class Design {
protected:
    Design() { reset(); }

    void reset() {
        top_.clk = 0;
        top_.rst = 1;
        top_.eval();
        for (int i = 0; i < 4; ++i) clock();
        top_.rst = 0;
        top_.eval();
    }

    void clock() {
        top_.clk = 1;
        top_.eval();
        top_.clk = 0;
        top_.eval();
    }

    // Clocks while a condition holds; returns the number of cycles.
    template <class Condition>
    Number clock_while(Condition holds) {
        for (Number i = 0; true; ++i) {
            top_.eval();
            if (!holds()) return i;
            if (i > limit_) give_up();
            clock();
        }
    }

    [[noreturn]] static void give_up() {
        std::fputs("harness: no answer of the design after very many cycles\n", stderr);
        std::exit(4);
    }

    static constexpr Number limit_ = 1ULL << 32;

    VerilatedContext context_;
    Vtop top_{&context_, ""};
};

}  // namespace harness
