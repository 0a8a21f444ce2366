// Drives the Verilated collision checker at full speed. Orders come on standard input, answers go
// to standard output:
//
//   1 n word*n            writes n cells, one payload of `writes` each
//   2 count stall n word*n m   checks m paths of n points, one payload of `points` each; `count` is
//                         the mode; with a stall s above 0, verdicts and counts are taken only in
//                         about one cycle of s
//       answers: m * (verdict payload, cycle in which it was first offered),
//                number of counts, their payloads, cycles from the first point to the last verdict
//   3 n word*n            looks up n cells (x | y << 32); answers n altitudes
//
// A payload of more than 64 bits takes as many numbers as it needs.

#include "harness.hpp"

namespace {

using namespace harness;

class Checker : Design {
public:
    void write(const Numbers& cells) {
        for (const auto cell : cells) {
            top_.writes___05Fpayload = cell;
            top_.writes___05Fvalid = 1;
            clock_while([&] { return !top_.writes___05Fready; });
            clock();
        }
        top_.writes___05Fvalid = 0;
        top_.eval();
    }

    Numbers check(bool count, Number stall, const Numbers& points, Number paths) {
        Numbers verdicts, counts;
        Number cycles = 0, taken = 0, finished = 0, entries = 0;
        std::size_t next = 0;
        Pauses pauses{stall};
        bool offered = false;
        top_.count = count;
        // Until the last point: the points of a dropped path must still be taken.
        while (finished < paths || next < points.size()) {
            pauses.draw();
            const bool take = pauses.moves();
            top_.points___05Fvalid = next < points.size();
            if (next < points.size()) top_.points___05Fpayload = points[next];
            top_.verdicts___05Fready = take;
            top_.counts___05Fready = take;
            top_.eval();
            const bool moved = top_.points___05Fvalid && top_.points___05Fready;
            if (taken > 0 || moved) ++cycles;
            if (top_.verdicts___05Fvalid && !offered) {
                offered = true;
                for (const auto number : read_port(top_.verdicts___05Fpayload)) verdicts.push_back(number);
                verdicts.push_back(cycles);
            }
            if (top_.verdicts___05Fvalid && take) ++finished, offered = false;
            if (top_.counts___05Fvalid && take) {
                ++entries;
                for (const auto number : read_port(top_.counts___05Fpayload)) counts.push_back(number);
            }
            if (moved) ++next, ++taken;
            clock();
            if (cycles > limit_) give_up();
        }
        // The counts of the last path may still be on their way.
        top_.points___05Fvalid = 0;
        top_.verdicts___05Fready = 0;
        top_.counts___05Fready = 1;
        top_.eval();
        while (top_.counts___05Fvalid) {
            ++entries;
            for (const auto number : read_port(top_.counts___05Fpayload)) counts.push_back(number);
            clock();
        }
        top_.counts___05Fready = 0;
        top_.eval();
        verdicts.push_back(entries);
        verdicts.insert(verdicts.end(), counts.begin(), counts.end());
        verdicts.push_back(cycles);
        return verdicts;
    }

    Numbers look_up(const Numbers& cells, Number latency) {
        Numbers altitudes;
        for (std::size_t i = 0; i < cells.size() + latency; ++i) {
            if (i < cells.size()) {
                top_.lookup_x = cells[i] & 0xffffffffU;
                top_.lookup_y = cells[i] >> 32;
            }
            top_.lookup_valid = i < cells.size();
            top_.eval();
            if (i >= latency) altitudes.push_back(top_.lookup_altitude);
            clock();
        }
        return altitudes;
    }
};

}  // namespace

int main() {
    Checker checker;
    for (Number order; next_order(order);) {
        if (order == 1) {
            checker.write(read_numbers(read_number()));
        } else if (order == 2) {
            const auto mode = read_numbers(2);
            const auto points = read_numbers(read_number());
            write_numbers(checker.check(mode[0], mode[1], points, read_number()));
        } else if (order == 3) {
            const Number latency = read_number();
            write_numbers(checker.look_up(read_numbers(read_number()), latency));
        } else {
            return 3;
        }
    }
    return 0;
}
