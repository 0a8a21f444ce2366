// Drives the Verilated collision checker at full speed. Orders come on standard input, answers go
// to standard output, all numbers 64-bit little-endian:
//
//   1 n word*n            writes n cells, one payload of `writes` each
//   2 count stall n word*n m   checks m paths of n points, one payload of `points` each; `count` is
//                         the mode; with a stall s above 0, verdicts and counts are taken only in
//                         about one cycle of s
//       answers: m * (verdict payload, cycle in which it was first offered),
//                number of counts, their payloads, cycles from the first point to the last verdict
//   3 n word*n            looks up n cells (x | y << 32); answers n altitudes
//
// Verilator spells the double underscore of a port ___05F.
//
// A payload of more than 64 bits takes as many numbers as it needs.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include <verilated.h>

#include "Vtop.h"

namespace {

using Number = std::uint64_t;

template <class Port>
std::vector<Number> read_port(const Port& port) {
    std::vector<Number> numbers((sizeof(Port) + sizeof(Number) - 1) / sizeof(Number), 0);
    std::memcpy(numbers.data(), &port, sizeof(Port));
    return numbers;
}

bool read_numbers(std::vector<Number>& numbers, std::size_t count) {
    numbers.resize(count);
    return std::fread(numbers.data(), sizeof(Number), count, stdin) == count;
}

Number read_number() {
    std::vector<Number> one;
    if (!read_numbers(one, 1)) std::exit(3);
    return one[0];
}

void write_numbers(const std::vector<Number>& numbers) {
    std::fwrite(numbers.data(), sizeof(Number), numbers.size(), stdout);
}

class Checker {
public:
    Checker() : context_{std::make_unique<VerilatedContext>()}, top_{std::make_unique<Vtop>(context_.get(), "")} {
        top_->clk = 0;
        top_->rst = 1;
        settle();
        for (int i = 0; i < 4; ++i) clock();
        top_->rst = 0;
        settle();
    }

    void write(const std::vector<Number>& cells) {
        for (const auto cell : cells) {
            top_->writes___05Fpayload = cell;
            top_->writes___05Fvalid = 1;
            settle();
            wait([&] { return top_->writes___05Fready; });
            clock();
        }
        top_->writes___05Fvalid = 0;
        settle();
    }

    std::vector<Number> check(bool count, Number stall, const std::vector<Number>& points, Number paths) {
        std::vector<Number> verdicts, counts;
        Number cycles = 0, taken = 0, finished = 0, entries = 0;
        std::size_t next = 0;
        Number random = 88172645463325252ULL;
        bool offered = false;
        top_->count = count;
        // Until the last point: the points of a dropped path must still be taken.
        while (finished < paths || next < points.size()) {
            random ^= random << 13, random ^= random >> 7, random ^= random << 17;
            const bool take = stall == 0 || random % stall == 0;
            top_->points___05Fvalid = next < points.size();
            if (next < points.size()) top_->points___05Fpayload = points[next];
            top_->verdicts___05Fready = take;
            top_->counts___05Fready = take;
            settle();
            const bool moved = top_->points___05Fvalid && top_->points___05Fready;
            if (taken > 0 || moved) ++cycles;
            if (top_->verdicts___05Fvalid && !offered) {
                offered = true;
                for (const auto number : read_port(top_->verdicts___05Fpayload)) verdicts.push_back(number);
                verdicts.push_back(cycles);
            }
            if (top_->verdicts___05Fvalid && take) ++finished, offered = false;
            if (top_->counts___05Fvalid && take) {
                ++entries;
                for (const auto number : read_port(top_->counts___05Fpayload)) counts.push_back(number);
            }
            if (moved) ++next, ++taken;
            clock();
            if (cycles > limit_) give_up("a verdict");
        }
        // The counts of the last path may still be on their way.
        top_->points___05Fvalid = 0;
        top_->verdicts___05Fready = 0;
        top_->counts___05Fready = 1;
        settle();
        while (top_->counts___05Fvalid) {
            ++entries;
            for (const auto number : read_port(top_->counts___05Fpayload)) counts.push_back(number);
            clock();
        }
        top_->counts___05Fready = 0;
        settle();
        verdicts.push_back(entries);
        verdicts.insert(verdicts.end(), counts.begin(), counts.end());
        verdicts.push_back(cycles);
        return verdicts;
    }

    std::vector<Number> look_up(const std::vector<Number>& cells, Number latency) {
        std::vector<Number> altitudes;
        for (std::size_t i = 0; i < cells.size() + latency; ++i) {
            if (i < cells.size()) {
                top_->lookup_x = cells[i] & 0xffffffffU;
                top_->lookup_y = cells[i] >> 32;
            }
            top_->lookup_valid = i < cells.size();
            settle();
            if (i >= latency) altitudes.push_back(top_->lookup_altitude);
            clock();
        }
        return altitudes;
    }

private:
    static constexpr Number limit_ = 1ULL << 36;

    void settle() { top_->eval(); }

    void clock() {
        top_->clk = 1;
        top_->eval();
        top_->clk = 0;
        top_->eval();
    }

    template <class Condition>
    void wait(Condition holds) {
        for (Number i = 0; !holds(); ++i) {
            if (i > limit_) give_up("a write");
            clock();
        }
    }

    [[noreturn]] static void give_up(const char* what) {
        std::fprintf(stderr, "checker: %s never came\n", what);
        std::exit(4);
    }

    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<Vtop> top_;
};

}  // namespace

int main() {
    Checker checker;
    std::vector<Number> order, words;
    while (read_numbers(order, 1)) {
        if (order[0] == 1) {
            if (!read_numbers(words, read_number())) return 3;
            checker.write(words);
        } else if (order[0] == 2) {
            const bool count = read_number();
            const Number stall = read_number();
            if (!read_numbers(words, read_number())) return 3;
            write_numbers(checker.check(count, stall, words, read_number()));
        } else if (order[0] == 3) {
            const Number latency = read_number();
            if (!read_numbers(words, read_number())) return 3;
            write_numbers(checker.look_up(words, latency));
        } else {
            return 3;
        }
        std::fflush(stdout);
    }
    return 0;
}
