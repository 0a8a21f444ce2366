// Drives the Verilated planner. Orders come on standard input, answers go to standard output, all
// numbers 64-bit little-endian; wide payloads are 32-bit words, one in each number:
//
//   1 n word*n        writes n corners, one payload of `cells` each
//   2 word*           a problem
//   3 word*           draws a shape; answers: cycles from its offer to its end
//   4 gap stop word*  starts a run `gap` cycles later, and stops it in that cycle (0: never)
//       answers: cycles of the run, generations that were told
//   5                 answers: has_problem, has_population, has_best, then the words of `status`
//   6 stall           reads the best paths; with a stall s above 0, records move only in about one
//                     cycle of s; answers: number of bytes, and the bytes
//   7 cycles word*    starts a run, and resets the chip after `cycles` cycles
//   8                 stops, while no run is in progress
//
// Verilator spells the double underscore of a port ___05F.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <verilated.h>

#include "Vtop.h"

namespace {

using Number = std::uint64_t;
using Numbers = std::vector<Number>;

constexpr Number LIMIT = 1ULL << 28;

Numbers read_numbers(std::size_t count) {
    Numbers numbers(count);
    if (std::fread(numbers.data(), sizeof(Number), count, stdin) != count) std::exit(3);
    return numbers;
}

Number read_number() { return read_numbers(1)[0]; }

void write_numbers(const Numbers& numbers) {
    std::fwrite(numbers.data(), sizeof(Number), numbers.size(), stdout);
}

class Planner {
public:
    Planner() {
        reset();
    }

    void stop() {
        top_.stop = 1;
        clock();
        top_.stop = 0;
    }

    void reset_in_run(Number cycles) {
        offer(top_.runs___05Fpayload, top_.runs___05Fvalid, top_.runs___05Fready);
        for (Number i = 0; i < cycles; ++i) clock();
        reset();
    }

    void write(const Numbers& corners) {
        top_.cells___05Fvalid = 1;
        for (const auto corner : corners) {
            top_.cells___05Fpayload = corner;
            take(top_.cells___05Fready);
        }
        top_.cells___05Fvalid = 0;
    }

    void pose() { offer(top_.problems___05Fpayload, top_.problems___05Fvalid, top_.problems___05Fready); }

    void draw() {
        write_numbers({offer(top_.shapes___05Fpayload, top_.shapes___05Fvalid, top_.shapes___05Fready)});
    }

    void run(Number gap, Number stop) {
        for (Number i = 0; i < gap; ++i) clock();
        offer(top_.runs___05Fpayload, top_.runs___05Fvalid, top_.runs___05Fready);
        // Offers in reset must not be taken.
        top_.cells___05Fvalid = top_.problems___05Fvalid = 1;
        top_.shapes___05Fvalid = top_.runs___05Fvalid = 1;
        Number cycle = 0, bred = 0;
        for (top_.eval(); top_.running; ++cycle, clock(), top_.eval()) {
            if (cycle > LIMIT) std::exit(4);
            top_.stop = stop != 0 && cycle == stop;
            top_.eval();
            bred += top_.bred;
            if (top_.cells___05Fready || top_.problems___05Fready || top_.shapes___05Fready ||
                top_.runs___05Fready) {
                std::exit(5);
            }
        }
        top_.cells___05Fvalid = top_.problems___05Fvalid = 0;
        top_.shapes___05Fvalid = top_.runs___05Fvalid = top_.stop = 0;
        write_numbers({cycle, bred});
    }

    void tell() {
        for (int i = 0; i < 4; ++i) clock();
        top_.eval();
        Numbers answer{top_.has_problem, top_.has_population, top_.has_best};
        for (std::size_t i = 0; i < sizeof top_.status / 4; ++i) answer.push_back(top_.status[i]);
        write_numbers(answer);
    }

    void read_best(Number stall) {
        top_.best = 1;
        clock();
        top_.best = 0;
        Numbers bytes{0};
        Number random = 88172645463325252ULL;
        for (Number i = 0; true; ++i) {
            if (i > LIMIT) std::exit(4);
            random ^= random << 13, random ^= random >> 7, random ^= random << 17;
            top_.records___05Fready = stall == 0 || random % stall == 0;
            top_.eval();
            const bool moves = top_.records___05Fvalid && top_.records___05Fready;
            const Number record = top_.records___05Fpayload;
            clock();
            if (moves) bytes.push_back(record & 0xFF);
            if (moves && record >> 8) break;
        }
        top_.records___05Fready = 0;
        bytes[0] = bytes.size() - 1;
        write_numbers(bytes);
    }

private:
    void reset() {
        top_.rst = 1;
        for (int i = 0; i < 4; ++i) clock();
        top_.rst = 0;
    }

    void clock() {
        top_.clk = 0;
        top_.eval();
        top_.clk = 1;
        top_.eval();
    }

    Number take(const CData& ready) {
        for (Number i = 0; i <= LIMIT; ++i) {
            top_.clk = 0;
            top_.eval();
            const bool taken = ready;
            clock();
            if (taken) return i;
        }
        std::exit(4);
    }

    template <typename Payload>
    Number offer(Payload& payload, CData& valid, const CData& ready) {
        for (std::size_t i = 0; i < sizeof payload / 4; ++i) payload[i] = read_number();
        valid = 1;
        const Number cycles = take(ready);
        valid = 0;
        return cycles;
    }

    VerilatedContext context_;
    Vtop top_{&context_, ""};
};

}  // namespace

int main() {
    Planner planner;
    Number order;
    while (std::fread(&order, sizeof order, 1, stdin) == 1) {
        if (order == 1) {
            planner.write(read_numbers(read_number()));
        } else if (order == 2) {
            planner.pose();
        } else if (order == 3) {
            planner.draw();
        } else if (order == 4) {
            const Numbers head = read_numbers(2);
            planner.run(head[0], head[1]);
        } else if (order == 5) {
            planner.tell();
        } else if (order == 6) {
            planner.read_best(read_number());
        } else if (order == 7) {
            planner.reset_in_run(read_number());
        } else if (order == 8) {
            planner.stop();
        } else {
            return 3;
        }
        std::fflush(stdout);
    }
    return 0;
}
