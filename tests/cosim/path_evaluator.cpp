// Drives the Verilated evaluator of paths. Orders come on standard input, answers go to standard
// output, all numbers 64-bit little-endian:
//
//   1 n word*n        writes n corners, one payload of `writes` each
//   2 n word*n        gives the problem, 32 bits in each number, and voids the memo
//   3 stall p (head gap points)*p  n word*n
//                     evaluates p paths: payload of each head, cycles to wait before its first
//                     point is offered, its number of points; then the payloads of all points. With
//                     a stall s above 0, points and keys move only in about one cycle of s.
//       answers: p * (payload of the key, cycles in which the first point was offered, the goal
//                taken, the key taken), the cycles of walking, the number of margins, p * (bits of
//                the decision, its cycle), and of each margin its bits and its cycle
//
// A slot of the scorer begins with an even cycle. Verilator spells the double underscore of a port
// ___05F.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include <verilated.h>

#include "Vtop.h"

namespace {

using Number = std::uint64_t;
using Numbers = std::vector<Number>;

Numbers read_numbers(std::size_t count) {
    Numbers numbers(count);
    if (std::fread(numbers.data(), sizeof(Number), count, stdin) != count) std::exit(3);
    return numbers;
}

Number read_number() { return read_numbers(1)[0]; }

void write_numbers(const Numbers& numbers) {
    std::fwrite(numbers.data(), sizeof(Number), numbers.size(), stdout);
}

class Evaluator {
public:
    Evaluator()
        : context_{std::make_unique<VerilatedContext>()},
          top_{std::make_unique<Vtop>(context_.get(), "")} {
        top_->rst = 1;
        for (int i = 0; i < 4; ++i) clock();
        top_->rst = 0;
        rest();
    }

    void write(const Numbers& corners) {
        top_->writes___05Fvalid = 1;
        for (const auto corner : corners) {
            top_->writes___05Fpayload = corner;
            clock();
        }
        top_->writes___05Fvalid = 0;
        for (int i = 0; i < 4; ++i) clock();
    }

    void begin(const Numbers& words) {
        for (std::size_t i = 0; i < words.size(); ++i) top_->problem[i] = words[i];
        top_->clear = top_->clear_counters = 1;
        clock();
        top_->clear = top_->clear_counters = 0;
        rest();
    }

    void evaluate(Number stall, const Numbers& paths, const Numbers& points) {
        const std::size_t count = paths.size() / 3;
        Numbers keys, offers, goals, keyed, decided, margins;
        std::size_t head = 0, path = 0, point = 0;
        Number wait = paths[1] + 3, left = paths[2], random = 88172645463325252ULL;
        bool held = false;
        for (Number cycle = 0; keys.size() < count || !top_->idle; ++cycle) {
            if (cycle > limit_) std::exit(4);
            random ^= random << 13, random ^= random >> 7, random ^= random << 17;
            top_->phase = cycle & 1;
            top_->paths___05Fvalid = head < count;
            if (head < count) top_->paths___05Fpayload = paths[3 * head];
            // An offer stays until it is taken.
            const bool may =
                path < count && wait == 0 && (held || stall == 0 || random % stall == 0);
            top_->points___05Fvalid = may;
            if (may) {
                top_->points___05Fpayload = points[point];
                if (offers.size() == path) offers.push_back(cycle);
            }
            top_->evaluated___05Fready = stall == 0 || (random >> 20) % stall == 0;
            top_->eval();
            held = may && !top_->points___05Fready;
            if (wait > 0) --wait;
            if (may && top_->points___05Fready) {
                ++point;
                if (--left == 0) {
                    goals.push_back(cycle);
                    if (++path < count) wait = paths[3 * path + 1], left = paths[3 * path + 2];
                }
            }
            if (head < count && top_->paths___05Fready) ++head;
            if (top_->decided & 1) decided.insert(decided.end(), {top_->decided, cycle});
            if (top_->margin & 1) margins.insert(margins.end(), {top_->margin, cycle});
            if (top_->evaluated___05Fvalid && top_->evaluated___05Fready) {
                keys.push_back(top_->evaluated___05Fpayload);
                keyed.push_back(cycle);
            }
            clock();
        }
        if (point != points.size() || decided.size() != 2 * count) std::exit(5);
        for (std::size_t i = 0; i < count; ++i) {
            write_numbers({keys[i], offers[i], goals[i], keyed[i]});
        }
        write_numbers({top_->walk, margins.size() / 2});
        write_numbers(decided);
        write_numbers(margins);
    }

private:
    static constexpr Number limit_ = 1ULL << 32;

    void clock() {
        top_->clk = 1;
        top_->eval();
        top_->clk = 0;
        top_->eval();
    }

    void rest() {
        top_->eval();
        for (Number i = 0; top_->busy; ++i) {
            if (i > limit_) std::exit(4);
            clock();
        }
        for (int i = 0; i < 4; ++i) clock();
    }

    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<Vtop> top_;
};

}  // namespace

int main() {
    Evaluator evaluator;
    Number order;
    while (std::fread(&order, sizeof order, 1, stdin) == 1) {
        if (order == 1) {
            evaluator.write(read_numbers(read_number()));
        } else if (order == 2) {
            evaluator.begin(read_numbers(read_number()));
        } else if (order == 3) {
            const Number stall = read_number();
            const auto paths = read_numbers(3 * read_number());
            const auto points = read_numbers(read_number());
            evaluator.evaluate(stall, paths, points);
        } else {
            return 3;
        }
        std::fflush(stdout);
    }
    return 0;
}
