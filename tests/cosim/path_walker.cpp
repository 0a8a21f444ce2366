// Drives the Verilated walker of paths. Orders come on standard input, answers go to standard
// output, all numbers 64-bit little-endian:
//
//   1 n word*n        writes n corners, one payload of `writes` each
//   2 start entry exit
//                     where all paths begin, and whether they have chords at start and goal; then
//                     `clear`
//   3 stall p (first gap points)*p  n word*n  m word*m
//                     walks p paths: `first`, cycles to wait before the path is offered, its number
//                     of points; then the payloads of all points and of all chords. With a stall
//                     s above 0, points, chords and results move only in about one cycle of s.
//       answers: p * (hits, cycle in which the first point was offered, cycle in which the result
//                was), number of margins, and of each its index and bits
//
// Verilator spells the double underscore of a port ___05F.

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

class Walker {
public:
    explicit Walker(int index_bits)
        : index_bits_{index_bits}, context_{std::make_unique<VerilatedContext>()},
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
        top_->start = words[0];
        top_->has_entry = words[1];
        top_->has_exit = words[2];
        top_->clear = 1;
        clock();
        top_->clear = 0;
        rest();
    }

    void walk(Number stall, const Numbers& paths, const Numbers& points, const Numbers& chords) {
        const std::size_t count = paths.size() / 3;
        Numbers results, margins, offers;
        std::size_t path = 0, left = 0, point = 0, chord = 0, offered = 0;
        Number cycle = 0, wait = 0, random = 88172645463325252ULL;
        bool is_new = true;
        bool result_seen = false;
        for (std::size_t finished = 0; finished < count; ++cycle) {
            if (cycle > limit_) std::exit(4);
            random ^= random << 13, random ^= random >> 7, random ^= random << 17;
            const bool moves[3] = {stall == 0 || random % stall == 0, stall == 0 || (random >> 20) % stall == 0,
                                   stall == 0 || (random >> 40) % stall == 0};
            if (path < count && is_new) {
                wait = paths[3 * path + 1], left = paths[3 * path + 2];
                is_new = false;
            }
            // What is offered stays so until it is taken.
            const bool may = path < count && wait == 0 && (moves[0] || held_point_);
            top_->points___05Fvalid = may;
            if (may) {
                top_->points___05Fpayload = points[point];
                top_->first = paths[3 * path];
                if (left == paths[3 * path + 2] && offered == path) offers.push_back(cycle), ++offered;
            }
            const bool chord_may = chord < chords.size() && (moves[1] || held_chord_);
            top_->chords___05Fvalid = chord_may;
            if (chord_may) top_->chords___05Fpayload = chords[chord];
            top_->results___05Fready = moves[2];
            top_->eval();
            held_point_ = may && !top_->points___05Fready;
            held_chord_ = chord_may && !top_->chords___05Fready;
            if (wait > 0 && !is_new) --wait;
            if (may && top_->points___05Fready) {
                ++point;
                if (--left == 0) ++path, is_new = true;
            }
            if (chord_may && top_->chords___05Fready) ++chord;
            if (top_->results___05Fvalid && !result_seen) {
                result_seen = true;
                results.push_back(top_->results___05Fpayload);
                results.push_back(offers[finished]);
                results.push_back(cycle);
            }
            if (top_->margins & 1) {
                // A margin comes before the result of its path, and may come beside that of others.
                margins.push_back(top_->margins >> 1 & ((1 << index_bits_) - 1));
                margins.push_back(top_->margins >> (1 + index_bits_));
            }
            if (top_->results___05Fvalid && moves[2]) ++finished, result_seen = false;
            clock();
        }
        top_->points___05Fvalid = top_->chords___05Fvalid = top_->results___05Fready = 0;
        rest();
        if (point != points.size() || chord != chords.size()) std::exit(5);
        results.push_back(margins.size() / 2);
        write_numbers(results);
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

    int index_bits_;
    bool held_point_ = false, held_chord_ = false;
    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<Vtop> top_;
};

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    Walker walker{std::atoi(arguments[1])};
    Number order;
    while (std::fread(&order, sizeof order, 1, stdin) == 1) {
        if (order == 1) {
            walker.write(read_numbers(read_number()));
        } else if (order == 2) {
            walker.begin(read_numbers(3));
        } else if (order == 3) {
            const Number stall = read_number();
            const auto paths = read_numbers(3 * read_number());
            const auto points = read_numbers(read_number());
            const auto chords = read_numbers(read_number());
            walker.walk(stall, paths, points, chords);
        } else {
            return 3;
        }
        std::fflush(stdout);
    }
    return 0;
}
