// Drives the Verilated walker of paths. Orders come on standard input, answers go to standard
// output, all numbers 64-bit little-endian:
//
//   1 n word*n        writes n corners, one payload of `writes` each
//   2                 `clear`
//   3 stall p (gap segments)*p  n word*n
//                     walks p paths: cycles to wait before the path is offered, its number of
//                     segments; then the payloads of all segments. With a stall s above 0, segments
//                     move only in about one cycle of s.
//       answers: p * (hits, cycle in which the first segment was offered, cycle of the result),
//                number of margins, and of each its index and bits; then the cycles of launching

#include "../../sim/harness/harness.hpp"

namespace {

using namespace harness;

class Walker : Design {
public:
    explicit Walker(int index_bits) : index_bits_{index_bits} { rest(); }

    void write(const Numbers& corners) {
        top_.writes___05Fvalid = 1;
        for (const auto corner : corners) {
            top_.writes___05Fpayload = corner;
            clock();
        }
        top_.writes___05Fvalid = 0;
        for (int i = 0; i < 4; ++i) clock();
    }

    void begin() {
        top_.clear = 1;
        clock();
        top_.clear = 0;
        rest();
    }

    void walk(Number stall, const Numbers& paths, const Numbers& segments) {
        const std::size_t count = paths.size() / 2;
        Numbers results, margins, offers;
        std::size_t path = 0, left = 0, segment = 0, offered = 0;
        Number cycle = 0, wait = 0, launched = 0;
        Pauses pauses{stall};
        bool is_new = true;
        for (std::size_t finished = 0; finished < count; ++cycle) {
            if (cycle > limit_) give_up();
            pauses.draw();
            if (path < count && is_new) {
                wait = paths[2 * path], left = paths[2 * path + 1];
                is_new = false;
            }
            // An offer stays until it is taken.
            const bool may = path < count && wait == 0 && (held_ || pauses.moves());
            top_.segments___05Fvalid = may;
            if (may) {
                top_.segments___05Fpayload = segments[segment];
                if (offered == path) offers.push_back(cycle), ++offered;
            }
            top_.eval();
            held_ = may && !top_.segments___05Fready;
            if (wait > 0 && !is_new) --wait;
            if (may && top_.segments___05Fready) {
                ++segment;
                if (--left == 0) ++path, is_new = true;
            }
            launched += top_.launching;
            if (top_.margin & 1) {
                margins.push_back(top_.margin >> 1 & ((1 << index_bits_) - 1));
                margins.push_back(top_.margin >> (1 + index_bits_));
            }
            if (top_.result & 1) {
                results.push_back(top_.result >> 1);
                results.push_back(offers[finished++]);
                results.push_back(cycle);
            }
            clock();
        }
        top_.segments___05Fvalid = 0;
        rest();
        if (segment != segments.size()) std::exit(5);
        results.push_back(margins.size() / 2);
        write_numbers(results);
        write_numbers(margins);
        write_numbers({launched});
    }

private:
    void rest() {
        clock_while([&] { return top_.busy; });
        for (int i = 0; i < 4; ++i) clock();
    }

    int index_bits_;
    bool held_ = false;
};

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    Walker walker{std::atoi(arguments[1])};
    for (Number order; next_order(order);) {
        if (order == 1) {
            walker.write(read_numbers(read_number()));
        } else if (order == 2) {
            walker.begin();
        } else if (order == 3) {
            const Number stall = read_number();
            const auto paths = read_numbers(2 * read_number());
            walker.walk(stall, paths, read_numbers(read_number()));
        } else {
            return 3;
        }
    }
    return 0;
}
